"""Results of the study: one for each sequence, and within it one for each method and seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.estimate import MotionEstimate
from detector.metrics import Box

F32 = npt.NDArray[np.float32]
STILL, DEFAULT_SENSOR = "still", "default"
"""Background and sensor of the paper's sequences; `scenarios.study.conditions` has the others."""


@dataclass(frozen=True)
class Snapshot:
    """Output of the sensor and of the fly at one moment, and the position of the vehicle.

    Attributes:
        t_us: time [µs].
        aps: (height, width) uint16, the last APS frame [DN].
        saliency: (rows, columns) float32, saliency map of the fly, dimensionless.
        cell_px: side of one cell of the map [px].
        roi_px: region of interest of the fly; None if it attends to nothing [px].
        box_px: true box of the vehicle; None if it is out of view [px].
    """

    t_us: int
    aps: npt.NDArray[np.uint16]
    saliency: F32
    cell_px: int
    roi_px: Box | None
    box_px: Box | None


@dataclass(frozen=True)
class MethodRun:
    """Estimates of one method on one sequence, seen by the sensor of one seed.

    Attributes:
        method: name of the method in `scenarios.pipeline.registry`.
        seed: seed of the sensor.
        estimates: all estimates.
        scores: comparison of the estimates with the ground truth, see
            `scenarios.pipeline.scoring.score_estimates`.
        velocity_error_px_s: root mean square error of the horizontal velocity, over the steps after
            100 ms in view that name a direction [px/s]; None if the method gives no velocity, or if
            there is no such step.
        cpu_s: CPU time of all calls [s].
        events: number of events given to the method.
        velocity_bias_px_s: mean error of the horizontal velocity over the same steps [px/s]; None
            like `velocity_error_px_s`.
        failure: reason why the method failed; None if it did not.
        sensor: name of the sensor's configuration; see `scenarios.study.conditions`.
    """

    method: str
    seed: int
    estimates: tuple[MotionEstimate, ...]
    scores: Mapping[str, Any]
    velocity_error_px_s: float | None
    cpu_s: float
    events: int
    velocity_bias_px_s: float | None = None
    failure: str | None = None
    sensor: str = DEFAULT_SENSOR


@dataclass(frozen=True)
class SequenceResult:
    """One of the paper's crossings, and the estimates of every method on it.

    Attributes:
        lighting: "day" or "night".
        omega_rad_s: angular velocity at closest approach [rad/s].
        speed_km_h: speed of the vehicle [km/h].
        duration_us: duration [µs].
        in_view_us: first and last time at which the vehicle is in view [µs].
        velocity_t_us: (n,) int64, times of `velocity_px_s` [µs].
        velocity_px_s: (n,) float64, true horizontal image velocity of the vehicle [px/s].
        snapshots: moments for the figures, of the first seed, in order of time.
        runs: one for each method and seed.
        direction: true direction.
        background: what moves in the background; see `scenarios.study.conditions`.
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
    background: str = STILL

    @property
    def name(self) -> str:
        """Name of its rows and its recording; see `sequence_name`."""
        return sequence_name(self.lighting, self.omega_rad_s, self.background)

    @property
    def image_speed_px_s(self) -> float:
        """Highest image speed of the vehicle, which it has at closest approach [px/s]."""
        return float(abs(self.velocity_px_s).max())


def sequence_name(lighting: str, omega_rad_s: float, background: str = STILL) -> str:
    """Return lighting, angular velocity and moving background, such as "day_1.61_wind"."""
    ending = "" if background == STILL else f"_{background}"
    return f"{lighting}_{omega_rad_s:.2f}{ending}"


def with_runs_of(sequences: Sequence[SequenceResult], sensor: str) -> list[SequenceResult]:
    """Return the sequences with the runs of one sensor only."""
    return [
        replace(sequence, runs=tuple(run for run in sequence.runs if run.sensor == sensor))
        for sequence in sequences
    ]


def without_failed(
    sequences: Sequence[SequenceResult],
) -> tuple[list[SequenceResult], dict[str, str]]:
    """Leave out every method that failed in any sequence, so that all methods can be compared.

    Returns:
        The sequences with the runs of the other methods, and the first reason of each failed
        method by its name.
    """
    failed: dict[str, str] = {}
    for sequence in sequences:
        for run in sequence.runs:
            if run.failure is not None:
                failed.setdefault(run.method, f"{run.failure} (sequence {sequence.name})")
    kept = [
        replace(sequence, runs=tuple(run for run in sequence.runs if run.method not in failed))
        for sequence in sequences
    ]
    return kept, failed
