"""The calibration as JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from scenarios.calibrate.calibration import Calibration
from scenarios.calibrate.fit import Fit, Parameter
from scenarios.calibrate.prediction import Prediction
from scenarios.output.atomic_folder import GENERATOR


def calibration_dict(
    calibration: Calibration,
    prediction: Prediction | None,
    *,
    recording: str,
    changes: Mapping[str, Any],
    versions: Mapping[str, str],
) -> dict[str, Any]:
    """Return a calibration as plain lists, strings and finite numbers.

    Args:
        calibration: the calibration.
        prediction: how well half of the recording predicts the other; None: not tried.
        recording: name of the recording.
        changes: preset and parameters of the sensor from which the fits started.
        versions: versions of the programs used, by name.
    """
    return {
        "generator": GENERATOR,
        "recording": recording,
        "start": dict(changes),
        "versions": dict(versions),
        "sensor": asdict(calibration.sensor),
        "parameters": {p.name: _parameter(p) for p in calibration.parameters},
        "figures": {fit.key: _figures(fit) for fit in calibration.fits},
        "prediction": None if prediction is None else asdict(prediction),
    }


def _parameter(parameter: Parameter) -> dict[str, Any]:
    interval = None if parameter.interval is None else list(parameter.interval)
    return {
        "value": parameter.value,
        "interval": interval,
        "unit": parameter.unit,
        "evidence": parameter.evidence,
    }


def _figures(fit: Fit) -> list[dict[str, Any]]:
    return [
        {"name": q.name, "unit": q.unit, "value": _finite(q.measured), "note": q.note}
        for q in fit.section.quantities
    ]


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
