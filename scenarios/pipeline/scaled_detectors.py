"""Scale the parameters of a detector to another sensor size or speed of motion.

The parameters of the detectors are those for a DAVIS346. Lengths in the image grow with the
sensor's width: cells, all distances counted in cells, and regions. Lengths on the chip stay as they
are, such as the neighbourhood in which a plane is fitted to an edge.
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
"""Width of the sensor that the parameters are made for."""
_MAX_SCALE = 1000.0
"""Greatest factor by which times may be scaled up or down (assumed)."""

_IMAGE_LENGTHS_PX = ("cell_px", "roi_radius_px")
_SPEEDS_PX_S = ("limit_px_s", "slowest_px_s")
_HOP = "hop_us"
"""Name of the parameter of which other times are multiples."""


@dataclass(frozen=True)
class ScaledDetector:
    """A fresh detector and its scaled parameters.

    Attributes:
        detector: the detector.
        changes: values of the scaled parameters, by name; empty if none was scaled.
    """

    detector: Detector
    changes: Mapping[str, Any]


def make_scaled(
    method: str, *, width: int, height: int, to_sensor: bool = False, time_scale: float = 1.0
) -> ScaledDetector:
    """Return a fresh detector for a sensor of any size.

    Args:
        method: name of the detector; see `scenarios.pipeline.user_detectors.find_method`.
        width: sensor columns [px].
        height: sensor rows [px].
        to_sensor: True to multiply lengths in the image by width / 346.
        time_scale: factor for all times; above 1 for slower motion.

    Raises:
        MethodError: there is no such method.
        ScenarioError: the method is a user's class, which cannot be scaled, or the scale is out of
            range.
        DetectorConfigError: the sensor is too small for the method, or a scaled parameter is out of
            its range.
    """
    if not (math.isfinite(time_scale) and 1 / _MAX_SCALE <= time_scale <= _MAX_SCALE):
        raise ScenarioError(
            f"--time-scale is {time_scale}. Allowed is a number from {1 / _MAX_SCALE:g} to "
            f"{_MAX_SCALE:g}. The default is 1, which leaves times unchanged."
        )
    length_scale = width / WIDTH_PX if to_sensor else 1.0
    if length_scale == 1.0 and time_scale == 1.0:
        return ScaledDetector(find_method(method).make(width=width, height=height), {})
    if method not in DETECTORS:
        find_method(method)
        raise ScenarioError(
            f"The method is {method}, whose parameters cannot be scaled. Allowed with "
            f"--scale-to-sensor and --time-scale is {', '.join(DETECTORS)}. Let your class scale "
            "its parameters by width and height."
        )
    entry = DETECTORS[method]
    changes = _changes(entry.config, length_scale, time_scale)
    return ScaledDetector(entry.make_with(changes, width=width, height=height), changes)


def _changes(config: Any, length_scale: float, time_scale: float) -> dict[str, Any]:
    """Return the parameters that scaling changes; multiples of the hop stay multiples of it."""
    scaled: dict[str, Any] = {}
    hop_us = getattr(config, _HOP, None)
    new_hop_us = None if hop_us is None else _scaled_time(hop_us, time_scale)
    for name in (field.name for field in fields(config)):
        value = getattr(config, name)
        if name == _HOP:
            scaled[name] = new_hop_us
        elif name in _IMAGE_LENGTHS_PX:
            scaled[name] = max(1, round(value * length_scale))
        elif name in _SPEEDS_PX_S:
            scaled[name] = value * length_scale / time_scale
        elif name.endswith("_us") and isinstance(value, tuple):
            scaled[name] = tuple(_keep_hops(each, hop_us, new_hop_us, time_scale) for each in value)
        elif name.endswith("_us"):
            scaled[name] = _keep_hops(value, hop_us, new_hop_us, time_scale)
    return {name: value for name, value in scaled.items() if value != getattr(config, name)}


def _keep_hops(value_us: int, hop_us: int | None, new_hop_us: int | None, time_scale: float) -> int:
    """Scale a time; if it is a multiple of the old hop, return that multiple of the new hop."""
    if hop_us and new_hop_us and value_us and value_us % hop_us == 0:
        return value_us // hop_us * new_hop_us
    return _scaled_time(value_us, time_scale) if value_us else 0


def _scaled_time(value_us: int, time_scale: float) -> int:
    return max(1, round(value_us * time_scale))
