"""Samples beside events and frames: of the inertial measurement unit (IMU), and triggers.

This module runs in the process that parses files too; see `formats.columns`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

IMU_DTYPE = np.dtype(
    [
        ("t", "<i8"),
        ("acceleration_g", "<f4", (3,)),
        ("rotation_deg_s", "<f4", (3,)),
        ("magnetic_ut", "<f4", (3,)),
        ("temperature_c", "<f4"),
    ]
)
"""t: µs, as in events; acceleration along x, y, z [g]; angular velocity around x, y, z [deg/s];
magnetic field along x, y, z [µT]; temperature [°C]. NaN: not in the file."""

TRIGGER_DTYPE = np.dtype([("t", "<i8"), ("kind", "u1"), ("channel", "u1")])
"""t: µs, as in events; kind: a `TriggerKind`; channel: number of the input, 0 if there is one."""


class TriggerKind(IntEnum):
    """Kind of a trigger, numbered as in AEDAT 4 (dv-processing, `dv::TriggerType`)."""

    TIMESTAMP_RESET = 0
    EXTERNAL_RISING_EDGE = 1
    EXTERNAL_FALLING_EDGE = 2
    EXTERNAL_PULSE = 3
    GENERATOR_RISING_EDGE = 4
    GENERATOR_FALLING_EDGE = 5
    FRAME_START = 6
    FRAME_END = 7
    EXPOSURE_START = 8
    EXPOSURE_END = 9


@dataclass(frozen=True, eq=False)
class ParsedSamples:
    """IMU samples or triggers of a file.

    Attributes:
        samples: one-dimensional array of `IMU_DTYPE` or `TRIGGER_DTYPE`.
    """

    samples: npt.NDArray[Any]


def empty_imu() -> npt.NDArray[Any]:
    """Return an array of no IMU samples."""
    return np.empty(0, IMU_DTYPE)


def empty_triggers() -> npt.NDArray[Any]:
    """Return an array of no triggers."""
    return np.empty(0, TRIGGER_DTYPE)
