"""A run in numbers: what `summary.json` and the closing table say."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.estimate import Direction, MotionEstimate
from detector.metrics import accuracy, grms, onset_latency_us, verdict, within
from emulator import Cause, SensorOutput
from scenarios.config import RunConfig
from scenarios.output import GENERATOR
from sim import Crossing
from sim.vulkan import vulkan_devices

SETTLING_US = 100_000
"""After this long in view a direction is due: two windows of the paper's Δt."""
_LIBRARIES = (
    "flybench",
    "mujoco",
    "numpy",
    "numba",
    "opencv-python-headless",
    "h5py",
    "rerun-sdk",
)


@dataclass
class EventTally:
    """Counts events as they come."""

    on: int = 0
    off: int = 0
    by_cause: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(len(Cause), np.int64))

    def add(self, output: SensorOutput) -> None:
        """Count one step's events."""
        on = int(np.count_nonzero(output.events["p"]))
        self.on += on
        self.off += output.events.size - on
        self.by_cause += np.bincount(output.causes, minlength=len(Cause))

    def summary(self) -> dict[str, Any]:
        """Counts by polarity and by cause."""
        causes = {cause.name.lower(): int(self.by_cause[cause]) for cause in Cause}
        return {"count": self.on + self.off, "on": self.on, "off": self.off, "by_cause": causes}


def summarise(
    config: RunConfig,
    crossing: Crossing,
    tally: EventTally,
    estimates: Sequence[MotionEstimate],
    in_view_us: tuple[int, int],
) -> dict[str, Any]:
    """Everything about a run that is not an array, ready for JSON, but for its wall time.

    Args:
        config: the run.
        crossing: its scene.
        tally: its events.
        estimates: all that the fly said.
        in_view_us: when the target was first and last in view [µs].
    """
    return {
        "generator": GENERATOR,
        "parameters": asdict(config) | {"crossing": config.crossing.resolved()},
        "seed": config.seed,
        "versions": {"python": platform.python_version()}
        | {name: version(name) for name in _LIBRARIES},
        "devices": [f"{device.name}: {device.driver}" for device in vulkan_devices()],
        "truth": _truth(config, crossing, in_view_us),
        "events": tally.summary(),
        "fly": judge(estimates, config.crossing.direction, in_view_us),
    }


def judge(
    estimates: Sequence[MotionEstimate], direction: str, in_view_us: tuple[int, int]
) -> dict[str, Any]:
    """What a detector said over a crossing, against the truth.

    Args:
        estimates: all that it said.
        direction: the true one.
        in_view_us: when the target was first and last in view [µs].

    Returns:
        direction: its verdict over the steps in view; accuracy: share of those whose direction is
        right, and the same after the first `SETTLING_US`; latency: from the first pixel in view
        to the first right step [ms], None where there was none; GRMS of the response [1/s].
    """
    truth = Direction(direction)
    settled_us = in_view_us[0] + SETTLING_US, in_view_us[1]
    latency_us = onset_latency_us(estimates, truth, crossing_us=in_view_us)
    return {
        "direction": verdict(estimates, crossing_us=in_view_us).value,
        "accuracy": accuracy(estimates, truth, crossing_us=in_view_us),
        "accuracy_after_100ms": accuracy(estimates, truth, crossing_us=settled_us),
        "steps_in_view": len(within(estimates, in_view_us)),
        "latency_ms": None if latency_us is None else latency_us / 1e3,
        "grms": grms(estimates, crossing_us=in_view_us),
    }


def _truth(config: RunConfig, crossing: Crossing, in_view_us: tuple[int, int]) -> dict[str, Any]:
    c = config.crossing
    speed_m_s = crossing.trajectory.speed_m_s(0.0)
    return {
        "direction": c.direction.value,
        "omega_rad_s": c.omega_rad_s,
        "speed_km_h": speed_m_s * 3.6,
        "image_speed_px_s": crossing.intrinsics.focal_px * speed_m_s / c.distance,
        "enters_view_us": in_view_us[0],
        "leaves_view_us": in_view_us[1],
        "duration_us": crossing.duration_us,
    }
