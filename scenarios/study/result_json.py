"""Results of a sequence as JSON, without loss."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

import numpy as np

from detector.estimate import MotionEstimate
from flybench.direction import Direction
from scenarios.study.results import MethodRun, SequenceResult, Snapshot

_ARRAY = "dtype"
"""Key that distinguishes an array from other objects."""


def result_to_json(result: SequenceResult) -> str:
    """Return a result as text; numbers keep all their digits."""
    return json.dumps(asdict(result), default=_plain)


def result_from_json(text: str) -> SequenceResult:
    """Return the result that `result_to_json` wrote.

    Raises:
        ValueError, KeyError or TypeError: the text is not what was written.
    """
    values = json.loads(text, object_hook=_array)
    values["in_view_us"] = tuple(values["in_view_us"])
    values["snapshots"] = tuple(_snapshot(snapshot) for snapshot in values["snapshots"])
    values["runs"] = tuple(_run(run) for run in values["runs"])
    return SequenceResult(**values)


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return {_ARRAY: value.dtype.str, "values": value.tolist()}
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{value!r} has no form in JSON.")


def _array(values: dict[str, Any]) -> Any:
    return np.array(values["values"], values[_ARRAY]) if _ARRAY in values else values


def _snapshot(values: dict[str, Any]) -> Snapshot:
    return Snapshot(**values | {name: _box(values[name]) for name in ("roi_px", "box_px")})


def _run(values: dict[str, Any]) -> MethodRun:
    return MethodRun(**values | {"estimates": tuple(map(_estimate, values["estimates"]))})


def _estimate(values: dict[str, Any]) -> MotionEstimate:
    pairs = {name: tuple(values[name]) for name in ("response", "view_centre_px")}
    direction = Direction(values["direction"])
    return MotionEstimate(
        **values | pairs | {"direction": direction, "roi_px": _box(values["roi_px"])}
    )


def _box(values: Any) -> Any:
    return None if values is None else tuple(values)
