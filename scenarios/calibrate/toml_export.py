"""The calibrated sensor as a TOML file, with the evidence of each value in a comment."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

from scenarios.calibrate.calibration import Calibration
from scenarios.calibrate.fit import Parameter
from scenarios.calibrate.fits.flicker import Flicker

_WIDTH = 100
_DIGITS = 4


def sensor_toml(
    calibration: Calibration, changes: Mapping[str, Any], *, name: str, version: str
) -> str:
    """Return the text of the file, which `--sensor` takes.

    Args:
        calibration: the calibration.
        changes: preset and parameters of the sensor from which the fits started, in the form of
            the file (`scenarios.options.sensor`).
        name: name of the recording.
        version: version of the program.
    """
    told = {p.name: p for p in calibration.parameters if p.value is not None}
    kept = {k: v for k, v in changes.items() if not isinstance(v, Mapping) and k not in told}
    preset = kept.pop("preset")
    size = {"width": calibration.sensor.width, "height": calibration.sensor.height}
    lines = [f"# Sensor calibrated by flybench {version} from {name}.", ""]
    lines += [f"preset = {_literal(preset)}"]
    lines += [f"{key} = {_literal(value)}" for key, value in (kept | size).items()]
    lines += _flicker(calibration.flicker)
    for parameter in calibration.parameters:
        lines += ["", *_parameter(parameter, calibration)]
    for key, table in changes.items():
        if isinstance(table, Mapping):
            lines += ["", f"[{key}]", *(f"{k} = {_literal(v)}" for k, v in table.items())]
    return "\n".join(lines) + "\n"


def _parameter(parameter: Parameter, calibration: Calibration) -> Iterator[str]:
    unit = f" [{parameter.unit}]" if parameter.unit else ""
    yield from _comment(f"{parameter.name}{unit}: {parameter.text}.")
    if parameter.value is not None:
        yield f"{parameter.name} = {_literal(_rounded(parameter.value))}"
        return
    value: Any = calibration.sensor
    for part in parameter.name.split("."):
        value = getattr(value, part)
    yield f"# {parameter.name} = {_literal(value)}"


def _flicker(flicker: Flicker | None) -> Iterator[str]:
    if flicker is not None:
        yield ""
        yield from _comment(
            f"Lamps in the recording flicker at {flicker.hz:.2f} Hz, with a depth of "
            f"{flicker.depth or 0.0:.2g}. The sensor has no parameter for this."
        )


def _comment(text: str) -> Iterator[str]:
    one_line = " ".join(text.split())
    yield from textwrap.wrap(one_line, _WIDTH, initial_indent="# ", subsequent_indent="# ")


def _rounded(value: float | int) -> float | int:
    return value if isinstance(value, int) else float(f"{value:.{_DIGITS}g}")


def _literal(value: Any) -> str:
    """Return a value of a sensor in TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_literal, value))}]"
    if isinstance(value, int | float):
        return repr(value)
    text = str(value).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{text}"'
