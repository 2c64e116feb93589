"""Detectors whose settings in pixels and microseconds are scaled to another sensor or pace.

The settings are those of a DAVIS346. What is a length in the image (a cell, and with it all
distances counted in cells, a region) grows with the sensor's width; what is a length on the chip,
such as the neighbourhood in which a plane is fitted to an edge, does not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from detector.estimate import Detector
from scenarios.errors import ScenarioError
from scenarios.pipeline.registry import DETECTORS
from scenarios.pipeline.user_detectors import find_method

WIDTH_PX = 346
"""Of the sensor that settings are made for."""
_TIMES = 1000.0
"""Farthest that anything is scaled either way (assumed)."""

_IMAGE_LENGTHS_PX = ("cell_px", "roi_radius_px")
_SPEEDS_PX_S = ("limit_px_s",)
_FIRST = ("hop_us",)
"""What other times are multiples of."""


@dataclass(frozen=True)
class Scaled:
    """A fresh detector, and what about it is not as usual.

    Attributes:
        detector: the detector.
        changes: settings that were scaled, by name; empty where none was.
    """

    detector: Detector
    changes: Mapping[str, Any]


def make_scaled(
    method: str, *, width: int, height: int, to_sensor: bool = False, time_scale: float = 1.0
) -> Scaled:
    """A fresh detector for a sensor of any size.

    Args:
        method: its name; see `scenarios.pipeline.registry`.
        width: sensor columns [px].
        height: sensor rows [px].
        to_sensor: whether lengths in the image are multiplied by width / 346.
        time_scale: what all times are multiplied by; above 1 for slower motion.

    Raises:
        MethodError: there is no such method.
        ScenarioError: a class of the user's own is to be scaled, or the scale is out of range.
        DetectorConfigError: the sensor is too small for the method, or a scaled setting is out of
            its range.
    """
    if not (math.isfinite(time_scale) and 1 / _TIMES <= time_scale <= _TIMES):
        raise ScenarioError(
            f"--time-scale is {time_scale}; allowed is {1 / _TIMES:g} to {_TIMES:g}; 1 leaves "
            "times as they are"
        )
    length_scale = width / WIDTH_PX if to_sensor else 1.0
    if length_scale == 1.0 and time_scale == 1.0:
        return Scaled(find_method(method).make(width=width, height=height), {})
    if method not in DETECTORS:
        find_method(method)
        raise ScenarioError(
            f"the settings of {method} are its own; --scale-to-sensor and --time-scale work with "
            f"{', '.join(DETECTORS)}; scale them where they are, by width and height"
        )
    entry = DETECTORS[method]
    changes = _changes(entry.config, length_scale, time_scale)
    return Scaled(entry.make_with(changes, width=width, height=height), changes)


def _changes(config: Any, length_scale: float, time_scale: float) -> dict[str, Any]:
    """Settings that differ after scaling; multiples of the hop stay multiples of it."""
    scaled: dict[str, Any] = {}
    hop_us = getattr(config, "hop_us", None)
    new_hop_us = None if hop_us is None else _time(hop_us, time_scale)
    for name in (field.name for field in fields(config)):
        value = getattr(config, name)
        if name in _FIRST:
            scaled[name] = new_hop_us
        elif name in _IMAGE_LENGTHS_PX:
            scaled[name] = max(1, round(value * length_scale))
        elif name in _SPEEDS_PX_S:
            scaled[name] = value * length_scale / time_scale
        elif name.endswith("_us") and isinstance(value, tuple):
            scaled[name] = tuple(_like(each, hop_us, new_hop_us, time_scale) for each in value)
        elif name.endswith("_us"):
            scaled[name] = _like(value, hop_us, new_hop_us, time_scale)
    return {name: value for name, value in scaled.items() if value != getattr(config, name)}


def _like(value_us: int, hop_us: int | None, new_hop_us: int | None, time_scale: float) -> int:
    if hop_us and new_hop_us and value_us and value_us % hop_us == 0:
        return value_us // hop_us * new_hop_us
    return _time(value_us, time_scale) if value_us else 0


def _time(value_us: int, time_scale: float) -> int:
    return max(1, round(value_us * time_scale))
