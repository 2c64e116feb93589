"""A detector on the output of one sensor, with its estimates and its CPU time."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, is_dataclass
from typing import Any

import numpy as np

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyMaps
from emulator import ApsFrame, SensorOutput
from flybench.events import EVENT_DTYPE, Events, concatenate_events
from scenarios.pipeline.feeding import DetectorFeed, fly_maps
from scenarios.pipeline.registry import CONTRAST, DETECTORS, EDGE_INFORMED
from scenarios.pipeline.user_detectors import find_method
from scenarios.study.results import DEFAULT_SENSOR

CHUNK_US = 10_000
"""Duration of the events that a detector gets in one call: one hop of the fly [µs]."""
CONTRAST_HOP_US = 50_000
"""Time from one window of contrast maximisation to the next [µs]. It is the length of the windows,
so that each event is used once. Windows every 10 ms, as the fly has them, cost four times as much
in all, and those that end at the same time differ by less than 0.1 px/s (measured by day and at
night)."""
_WARM_UP_US = 300_000
_WARM_UP_PX_S = 400.0


def join_outputs(outputs: Sequence[SensorOutput]) -> tuple[Events, list[ApsFrame]]:
    """Return the events and the frames of several sensor steps, in order."""
    frames = [frame for output in outputs for frame in output.aps_frames]
    return concatenate_events([output.events for output in outputs]), frames


@dataclass
class TimedDetector:
    """A detector that collects its estimates and measures its CPU time.

    Attributes:
        feed: a fresh detector.
        seed: seed of the sensor.
        sensor: name of the sensor's configuration.
        estimates: all estimates so far.
        cpu_s: CPU time of all calls [s].
        events: number of events given to the detector.
    """

    feed: DetectorFeed
    seed: int
    sensor: str = DEFAULT_SENSOR
    estimates: list[MotionEstimate] = field(default_factory=list)
    cpu_s: float = 0.0
    events: int = 0

    @property
    def method(self) -> str:
        """Name of the method."""
        return self.feed.method

    @property
    def maps(self) -> FlyMaps | None:
        """Maps of a fly at its last estimate; None for other detectors."""
        return fly_maps(self.feed.detector)

    @property
    def config(self) -> Any | None:
        """Configuration of the detector, a dataclass; None for a user's class without one."""
        config = getattr(self.feed.detector, "config", None)
        return config if is_dataclass(config) else None

    def process(
        self, events: Events, frames: Sequence[ApsFrame], *, until_us: int
    ) -> list[MotionEstimate]:
        """Feed the next chunk to the detector.

        Args:
            events: next events of the stream.
            frames: next APS frames of the sensor.
            until_us: every event before this time has been passed [µs].

        Returns:
            The estimates that became due.
        """
        start_s = time.thread_time()
        estimates = self.feed.feed(events, until_us=until_us, frames=frames)
        self.cpu_s += time.thread_time() - start_s
        self.events += events.size
        self.estimates += estimates
        return estimates


def make_timed_detector(
    method: str,
    seed: int,
    *,
    width: int,
    height: int,
    contrast_hop_us: int = CONTRAST_HOP_US,
    sensor: str = DEFAULT_SENSOR,
) -> TimedDetector:
    """Make a detector for a sensor of this size.

    Args:
        method: name of the method.
        seed: seed of the sensor.
        width: columns of the sensor [px].
        height: rows of the sensor [px].
        contrast_hop_us: time between the windows of contrast maximisation [µs].
        sensor: name of the sensor's configuration.

    Raises:
        MethodError: there is no such method.
        DetectorConfigError: the hop does not divide the window of contrast maximisation.
    """
    size = {"width": width, "height": height}
    if method in (CONTRAST, EDGE_INFORMED):
        detector = DETECTORS[method].make_with({"hop_us": contrast_hop_us}, **size)
    else:
        detector = find_method(method).make(**size)
    return TimedDetector(DetectorFeed(method, detector, **size), seed, sensor)


def warm_up(detector: TimedDetector, *, width: int, height: int) -> None:
    """Run a detector once so that its kernels are compiled before its time is measured.

    Args:
        detector: a detector to discard afterwards; it sees a synthetic moving bar.
        width: columns of the sensor [px].
        height: rows of the sensor [px].
    """
    events, frames = _moving_bar(width, height)
    cuts = np.arange(CHUNK_US, _WARM_UP_US + 1, CHUNK_US)
    start = 0
    for until_us in cuts:
        end = int(np.searchsorted(events["t"], until_us))
        due = [f for f in frames if until_us - CHUNK_US < f.end_us <= until_us]
        detector.process(events[start:end].copy(), due, until_us=int(until_us))
        start = end


def _moving_bar(width: int, height: int) -> tuple[Events, list[ApsFrame]]:
    """Return synthetic events and frames of a moving bar with a rough edge."""
    rng = np.random.default_rng(0)
    number = 90_000  # dense enough for fits of planes
    events = np.empty(number, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(_WARM_UP_US, size=number))
    at = events["t"] * 1e-6 * _WARM_UP_PX_S + rng.choice([0, 11, 23], number)
    events["x"] = at.astype(np.int64) % width
    events["y"] = rng.integers(height, size=number)
    events["p"] = rng.integers(2, size=number) > 0
    image = rng.integers(1000, size=(height, width)).astype(np.uint16)
    times = range(25_000, _WARM_UP_US, 25_000)
    return events, [ApsFrame(t - 5_000, t, np.roll(image, t // 2500, axis=1)) for t in times]
