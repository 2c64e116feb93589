"""The calibration as one self-contained HTML page: parameters, and each fit over its data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

from emulator import SensorConfig
from scenarios.calibrate.calibration import Calibration
from scenarios.calibrate.fit import Fit, Parameter
from scenarios.calibrate.prediction import Prediction
from scenarios.datasheet.figures import draw_svg
from scenarios.datasheet.formatting import three_digits, with_unit
from scenarios.output.html import inline_svg, render

_TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True)
class ParameterRow:
    """One row of the table of parameters, as text."""

    name: str
    value: str
    interval: str
    start: str
    evidence: str


@dataclass(frozen=True)
class _Section:
    """One fit: id of its section, texts, table rows and figures."""

    name: str
    title: str
    method: str
    rows: Sequence[tuple[str, str, str]]
    figures: Sequence[Markup]


def render_page(
    calibration: Calibration,
    prediction: Prediction | None,
    *,
    recording: str,
    facts: str,
    start: SensorConfig,
    versions: Mapping[str, str],
) -> str:
    """Render the page.

    Args:
        calibration: the calibration.
        prediction: how well half of the recording predicts the other; None: not tried.
        recording: name of the recording.
        facts: number of events and frames, and duration.
        start: sensor from which the fits started.
        versions: versions of the programs used, by name.
    """
    return render(
        "calibration.html.j2",
        _TEMPLATES,
        title=f"Sensor calibrated from {recording}",
        facts=facts,
        programs=", ".join(f"{name} {number}" for name, number in versions.items()),
        parameters=parameter_rows(calibration, start),
        prediction=prediction and prediction_rows(prediction),
        sections=[_section(fit) for fit in calibration.fits],
    )


def parameter_rows(calibration: Calibration, start: SensorConfig) -> list[ParameterRow]:
    """Return one row for each parameter of the sensor."""
    return [_row(parameter, start) for parameter in calibration.parameters]


def _row(parameter: Parameter, start: SensorConfig) -> ParameterRow:
    default: Any = start
    for part in parameter.name.split("."):
        default = getattr(default, part)
    interval = ""
    if parameter.interval is not None:
        interval = " to ".join(map(three_digits, parameter.interval))
    value = "not told" if parameter.value is None else with_unit(parameter.value, parameter.unit)
    return ParameterRow(
        parameter.name, value, interval, with_unit(default, parameter.unit), parameter.evidence
    )


def prediction_rows(prediction: Prediction) -> list[tuple[str, str, str]]:
    """Return one row for the camera and each sensor: name, events, and error."""
    return [
        ("camera", three_digits(prediction.camera), ""),
        (
            "fitted to the first half",
            three_digits(prediction.fitted),
            three_digits(prediction.fitted_error),
        ),
        ("start", three_digits(prediction.start), three_digits(prediction.start_error)),
    ]


def _section(fit: Fit) -> _Section:
    section = fit.section
    rows = [(q.name, with_unit(q.measured, q.unit), q.note) for q in section.quantities]
    figures = [
        inline_svg(draw_svg(plot), prefix=f"{fit.key}-{number}", label=plot.title)
        for number, plot in enumerate(section.plots)
    ]
    return _Section(fit.key, section.title, section.method, rows, figures)
