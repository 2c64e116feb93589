"""Data for the figure of `flybench detect`, collected while the recording is read."""

from __future__ import annotations

from array import array
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from detector.estimate import MotionEstimate
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import Events, concatenate_events, empty_events
from scenarios.detect.run_detector import RecordingSlice

SNAPSHOT_US = 20_000
"""Duration of the events in the snapshot [µs], as in the view of a recording."""

DIRECTIONS = tuple(Direction)
"""Directions in the order of their codes in `PlotData.direction`."""

MAX_BINS = 2000
"""Most points of the event rate in a figure (assumed: about the width of the figure in pixels)."""

_RECENT_FRAMES = 8
"""Frames kept for the snapshot.

Assumed: an estimate refers to a time several hops before the events that triggered it, and a frame
is rarely shorter than a hop.
"""


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The recording at one moment.

    Attributes:
        estimate: the detector's estimate at that moment; None if there is none.
        events: events of the last `SNAPSHOT_US` before it.
        frame: the last APS frame that had ended by then; None if there is none.
    """

    estimate: MotionEstimate | None
    events: Events
    frame: ApsFrame | None


class PlotData:
    """Data of the figure; takes about 60 bytes an estimate.

    Attributes:
        t_us: time of each estimate [µs].
        hs: HS response of each estimate.
        vs: VS response of each estimate.
        direction: direction of each estimate, as its index in `DIRECTIONS`.
        rate_us: time of the last event of each slice [µs].
        on: number of ON events of each slice.
        off: number of OFF events of each slice.
        snapshot: the moment of the strongest estimate that names a direction; the last moment if
            there is none.
    """

    def __init__(self) -> None:
        self.t_us, self.rate_us = array("q"), array("q")
        self.hs, self.vs = array("f"), array("f")
        self.direction = array("b")
        self.on, self.off = array("l"), array("l")
        self.snapshot = Snapshot(None, empty_events(), None)
        self._strongest = 0.0
        self._recent = empty_events()
        self._frames: tuple[ApsFrame, ...] = ()

    def add(self, part: RecordingSlice) -> None:
        """Include a slice of the recording."""
        self._frames += part.frames
        if part.events.size:
            self._add_events(part.events)
        for estimate in part.estimates:
            self.t_us.append(estimate.t_us)
            self.hs.append(estimate.hs)
            self.vs.append(estimate.vs)
            self.direction.append(DIRECTIONS.index(estimate.direction))
            self._update_snapshot(estimate)
        # A later estimate may refer to a time before the most recent frames.
        self._frames = self._frames[-_RECENT_FRAMES:]

    def _add_events(self, events: Events) -> None:
        on = int(np.count_nonzero(events["p"]))
        last_us = int(events["t"][-1])
        self.rate_us.append(last_us)
        self.on.append(on)
        self.off.append(events.size - on)
        recent = concatenate_events([self._recent, events])
        # Keep twice the duration: an estimate refers to a time before the events that triggered it.
        self._recent = recent[recent["t"] > last_us - 2 * SNAPSHOT_US]
        if self._strongest == 0.0:
            self.snapshot = self._snapshot(None, last_us + 1)

    def _update_snapshot(self, estimate: MotionEstimate) -> None:
        if estimate.direction is not Direction.NONE and estimate.strength > self._strongest:
            self._strongest = estimate.strength
            self.snapshot = self._snapshot(estimate, estimate.t_us)

    def _snapshot(self, estimate: MotionEstimate | None, end_us: int) -> Snapshot:
        times_us = self._recent["t"]
        inside = (times_us >= end_us - SNAPSHOT_US) & (times_us < end_us)
        ended = [frame for frame in self._frames if frame.end_us <= end_us]
        return Snapshot(estimate, self._recent[inside], ended[-1] if ended else None)

    def rates(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Return the event rate in bins of 10 ms or more.

        Returns:
            (n,) centres of the bins [s], and (2, n) rates of ON and OFF events [events/s].
        """
        if not self.rate_us:
            return np.zeros(0), np.zeros((2, 0))
        ends_us = np.asarray(self.rate_us)
        bin_us = max(10_000, int(np.ptp(ends_us)) // MAX_BINS)
        bins, index = np.unique(ends_us // bin_us, return_inverse=True)
        counts = np.zeros((2, int(np.ptp(bins)) + 1 if bins.size < MAX_BINS * 2 else 0))
        for row, values in enumerate((self.on, self.off)):
            np.add.at(counts[row], bins[index] - bins[0], np.asarray(values))
        times_s = (bins[0] + np.arange(counts.shape[1]) + 0.5) * bin_us * 1e-6
        return times_s, counts / (bin_us * 1e-6)
