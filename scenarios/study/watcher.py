"""One method that watches one sensor: what it said, and the CPU time that it took."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, is_dataclass
from typing import Any

import numpy as np

from detector.estimate import Detector, MotionEstimate
from detector.fly.detector import FlyMaps
from emulator import ApsFrame, SensorOutput
from flybench.events import EVENT_DTYPE, Events, joined
from scenarios.pipeline.feeding import feed
from scenarios.pipeline.registry import CONTRAST, DETECTORS
from scenarios.pipeline.user_detectors import find_method

CHUNK_US = 10_000
"""What every detector is handed at once: the events of one hop of the fly's."""
CONTRAST_HOP_US = 50_000
"""Step from one window of contrast maximisation to the next: its windows' own length, so that each
event is looked at once. Windows every 10 ms, as the fly's, cost four times as much in all, and
those that end together differ by less than 0.1 px/s (measured by day and by night)."""
_WARM_UP_US = 300_000
_WARM_UP_PX_S = 400.0


def gathered(outputs: Sequence[SensorOutput]) -> tuple[Events, list[ApsFrame]]:
    """The events and the frames of several steps of a sensor, in their order."""
    frames = [frame for output in outputs for frame in output.aps_frames]
    return joined([output.events for output in outputs]), frames


@dataclass
class Watcher:
    """A detector at work.

    Attributes:
        method: its name.
        seed: of its sensor.
        detector: a fresh one.
        estimates: all that it said so far.
        cpu_s: CPU time of all its calls [s].
        events: how many it was shown.
    """

    method: str
    seed: int
    detector: Detector
    estimates: list[MotionEstimate] = field(default_factory=list)
    cpu_s: float = 0.0
    events: int = 0

    @property
    def maps(self) -> FlyMaps | None:
        """What a fly saw at its last estimate; another detector has no such maps."""
        maps = getattr(self.detector, "maps", None)
        return maps if isinstance(maps, FlyMaps) else None

    @property
    def config(self) -> Any | None:
        """The parameters of a detector of ours, a dataclass."""
        config = getattr(self.detector, "config", None)
        return config if is_dataclass(config) else None

    def watch(
        self, events: Events, frames: Sequence[ApsFrame], *, until_us: int
    ) -> list[MotionEstimate]:
        """Pass on the next chunk; returns what became due.

        Args:
            events: the next of the stream.
            frames: the next of the sensor's.
            until_us: every event before this was passed [µs].
        """
        start_s = time.thread_time()
        said = feed(
            self.detector, events, until_us=until_us, frames=frames, earlier=self.estimates[-1:]
        )
        self.cpu_s += time.thread_time() - start_s
        self.events += events.size
        self.estimates += said
        return said


def make_watcher(
    method: str, seed: int, *, width: int, height: int, contrast_hop_us: int = CONTRAST_HOP_US
) -> Watcher:
    """A method before a sensor of this size [px].

    Raises:
        MethodError: there is no such method.
        DetectorConfigError: the hop does not divide the window of contrast maximisation.
    """
    if method == CONTRAST:
        changes = {"hop_us": contrast_hop_us}
        detector = DETECTORS[method].make_with(changes, width=width, height=height)
        return Watcher(method, seed, detector)
    return Watcher(method, seed, find_method(method).make(width=width, height=height))


def warm_up(watcher: Watcher, *, width: int, height: int) -> None:
    """Have a method compile all that it needs, before its time counts.

    Args:
        watcher: of the method; it is shown a drawn bar that passes by, and is of no use afterwards.
        width: sensor columns [px].
        height: sensor rows [px].
    """
    events, frames = _drawn_bar(width, height)
    cuts = np.arange(CHUNK_US, _WARM_UP_US + 1, CHUNK_US)
    start = 0
    for until_us in cuts:
        end = int(np.searchsorted(events["t"], until_us))
        due = [f for f in frames if until_us - CHUNK_US < f.end_us <= until_us]
        watcher.watch(events[start:end].copy(), due, until_us=int(until_us))
        start = end


def _drawn_bar(width: int, height: int) -> tuple[Events, list[ApsFrame]]:
    """Events and frames of a bar with a rough edge."""
    rng = np.random.default_rng(0)
    number = 20_000
    events = np.empty(number, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(_WARM_UP_US, size=number))
    at = events["t"] * 1e-6 * _WARM_UP_PX_S + rng.choice([0, 11, 23], number)
    events["x"] = at.astype(np.int64) % width
    events["y"] = rng.integers(height, size=number)
    events["p"] = rng.integers(2, size=number) > 0
    image = rng.integers(1000, size=(height, width)).astype(np.uint16)
    times = range(25_000, _WARM_UP_US, 25_000)
    return events, [ApsFrame(t - 5_000, t, np.roll(image, t // 2500, axis=1)) for t in times]
