"""What the study found: one entry a sequence, and in it one a method and seed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.estimate import MotionEstimate
from detector.metrics import Box

F32 = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Snapshot:
    """What the sensor and the fly saw at one moment, and where the vehicle was.

    Attributes:
        t_us: the moment [µs].
        aps: (height, width) uint16, the last APS frame [DN].
        saliency: (rows, columns) float32, the fly's, dimensionless.
        cell_px: side of a cell of it [px].
        roi_px: the fly's region of interest; None where it attends to nothing [px].
        box_px: the vehicle's true box; None where it is out of view [px].
    """

    t_us: int
    aps: npt.NDArray[np.uint16]
    saliency: F32
    cell_px: int
    roi_px: Box | None
    box_px: Box | None


@dataclass(frozen=True)
class MethodRun:
    """What one method said of one sequence, seen by the sensor of one seed.

    Attributes:
        method: its name in `scenarios.pipeline.registry`.
        seed: the sensor's.
        estimates: all that it said.
        judgement: that against the truth, see `scenarios.pipeline.scoring.score_estimates`.
        velocity_error_px_s: root mean square error of its horizontal velocity, over those of the
            steps after 100 ms in view that name a direction [px/s]; None for a method that gives
            no velocity, and where there is no such step.
        cpu_s: CPU time of all its calls [s].
        events: how many events it was shown.
        velocity_bias_px_s: mean error of the same velocity in the same steps [px/s].
    """

    method: str
    seed: int
    estimates: tuple[MotionEstimate, ...]
    judgement: Mapping[str, Any]
    velocity_error_px_s: float | None
    cpu_s: float
    events: int
    velocity_bias_px_s: float | None = None


@dataclass(frozen=True)
class Sequence:
    """One of the paper's crossings, and what every method said of it.

    Attributes:
        lighting: "day" or "night".
        omega_rad_s: angular velocity at closest approach [rad/s].
        speed_km_h: the vehicle's speed [km/h].
        duration_us: how long it lasts [µs].
        in_view_us: when the vehicle was first and last in view [µs].
        velocity_t_us: (n,) int64, times of `velocity_px_s` [µs].
        velocity_px_s: (n,) float64, the vehicle's true horizontal image velocity [px/s].
        snapshots: moments for the figures, of the first seed, in order of time.
        runs: one a method and seed.
        direction: the true one.
    """

    lighting: str
    omega_rad_s: float
    speed_km_h: float
    duration_us: int
    in_view_us: tuple[int, int]
    velocity_t_us: npt.NDArray[np.int64]
    velocity_px_s: npt.NDArray[np.float64]
    snapshots: tuple[Snapshot, ...]
    runs: tuple[MethodRun, ...]
    direction: str = "right"

    @property
    def name(self) -> str:
        """Light and velocity, such as "day_1.21": of its rows and of its recording."""
        return f"{self.lighting}_{self.omega_rad_s:.2f}"

    @property
    def image_speed_px_s(self) -> float:
        """The vehicle's image speed when it is nearest, the highest of all [px/s]."""
        return float(abs(self.velocity_px_s).max())
