"""Conversion of events, IMU samples and triggers to the dtypes that faery takes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.events import Events

_DTYPE = np.dtype([("t", "<u8"), ("x", "<u2"), ("y", "<u2"), (("p", "on"), "?")])

_AXES = {
    "acceleration_g": "accelerometer",
    "rotation_deg_s": "gyroscope",
    "magnetic_ut": "magnetometer",
}
"""faery's name of the sensor, by field of `IMU_DTYPE`."""

_IMU_DTYPE = np.dtype(
    [("t", "<u8"), ("temperature", "<f4")]
    + [(f"{sensor}_{axis}", "<f4") for sensor in _AXES.values() for axis in "xyz"]
)
_TRIGGER_DTYPE = np.dtype([("t", "<u8"), ("source", "u1")])


def to_faery(events: Events) -> npt.NDArray[np.void]:
    """Return a view of events as unsigned numbers; none is negative, so the bytes are equal."""
    return np.ascontiguousarray(events).view(_DTYPE)


def to_faery_imu(samples: npt.NDArray[Any]) -> npt.NDArray[np.void]:
    """Return IMU samples of `formats.IMU_DTYPE` in the fields of faery; the units are the same."""
    converted = np.empty(samples.size, _IMU_DTYPE)
    converted["t"], converted["temperature"] = samples["t"], samples["temperature_c"]
    for name, sensor in _AXES.items():
        for axis, letter in enumerate("xyz"):
            converted[f"{sensor}_{letter}"] = samples[name][:, axis]
    return converted


def to_faery_triggers(samples: npt.NDArray[Any]) -> npt.NDArray[np.void]:
    """Return triggers of `formats.TRIGGER_DTYPE` in the fields of faery, without their channel."""
    converted = np.empty(samples.size, _TRIGGER_DTYPE)
    converted["t"], converted["source"] = samples["t"], samples["kind"]
    return converted
