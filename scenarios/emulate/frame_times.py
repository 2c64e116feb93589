"""Times of the frames of a video, a folder of images or an array."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import numpy.typing as npt

from emulator.readout.event_keys import MAX_STEP_US
from scenarios.emulate.time_unit import Unit, rounded
from scenarios.errors import ScenarioError
from sim.motion.sample_times import MIN_STEP_US

I64 = npt.NDArray[np.int64]

FPS_MIN, FPS_MAX = 0.1, 1e6 / MIN_STEP_US


@dataclass(frozen=True)
class TimeOptions:
    """What the user states about the times of the frames.

    Attributes:
        fps: frames per second, evenly spaced; None: the input's own times.
        file: text file with the time of each frame; None: the input's own times.
        unit: unit of the times in a text file or in file names; None: decided by their content.
    """

    fps: float | None = None
    file: Path | None = None
    unit: Unit | None = None


@dataclass(frozen=True, eq=False)
class FrameTimes:
    """Time of each frame.

    Attributes:
        t_us: (frames,) int64 time since the first frame, strictly increasing [µs].
        source: where the times come from, and why in this unit.
        hz: frames per second if they are evenly spaced; None otherwise.
        file: text file that they are read from; None: they come from elsewhere.
        warnings: doubts about the times, one sentence or more each.
    """

    t_us: I64
    source: str
    hz: float | None = None
    file: Path | None = None
    warnings: tuple[str, ...] = ()

    def rate(self) -> str:
        """Return the frame rate, or its range if it varies, for example `15 to 60 Hz, varies`."""
        if self.hz is not None or self.t_us.size < 2:
            return f"{self.hz or 0.0:g} Hz"
        steps = np.diff(self.t_us)
        low, high = (rounded(1e6 / step, 3) for step in (steps.max(), steps.min()))
        even_us = np.linspace(0, self.t_us[-1], self.t_us.size)
        rounded_to_ms = steps.min() > 2000 and not (self.t_us % 1000).any()
        resolution_us = 1000 if rounded_to_ms else 1
        if low == high or np.abs(self.t_us - even_us).max() <= resolution_us:
            return f"{rounded(1e6 / steps.mean(), 4)} Hz"
        return f"{low} to {high} Hz, varies"


def evenly_spaced(count: int, fps: float, source: str) -> FrameTimes:
    """Return the times of frames at a constant rate.

    Raises:
        ScenarioError: the rate is out of range.
    """
    if not FPS_MIN <= fps <= FPS_MAX:
        raise ScenarioError(
            f"The frame rate is {fps:g} frames per second. Allowed is {FPS_MIN:g} to "
            f"{FPS_MAX:g}. Give another with --fps."
        )
    t_us = np.rint(np.arange(count) * (1e6 / fps)).astype(np.int64)
    return FrameTimes(t_us, source, hz=fps)


def own_times(times_us: Sequence[Fraction], names: Sequence[str], source: str) -> FrameTimes:
    """Return the times that a file or the names of images give.

    Args:
        times_us: time of each frame, from any origin [µs].
        names: what each frame is called in error messages.
        source: where the times come from.

    Raises:
        ScenarioError: the times do not increase, or are too close or too far apart.
    """
    t_us = np.array([round(time - times_us[0]) for time in times_us], object)
    for k, step in enumerate(np.diff(t_us)):
        if not MIN_STEP_US <= step <= MAX_STEP_US:
            raise ScenarioError(
                f"{names[k + 1]} is {step / 1e6:g} s after {names[k]} ({source}). Allowed is "
                f"{MIN_STEP_US / 1e6:g} to {MAX_STEP_US / 1e6:.0f} s. Correct the times, or give "
                "their unit with --time-unit or a constant rate with --fps."
            )
    return FrameTimes(t_us.astype(np.int64), source)
