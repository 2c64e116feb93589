"""What adds up over a recording: the verdict, and what its figure shows."""

from __future__ import annotations

from array import array
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from detector.estimate import MotionEstimate
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import Events, empty_events, joined
from scenarios.detect.watching import Look

PICTURE_US = 20_000
"""Span of the events in the figure's picture; as in a recording."""
Box = tuple[int, int, int, int]


class Verdict:
    """The one direction of a recording: that with most strength, summed over its steps.

    The same as `detector.metrics.verdict`, of all the steps, since nobody knows when what moved
    came and went.

    Attributes:
        steps: estimates so far.
        strengths: by direction, summed over the steps that named it.
        counts: by direction, how many named it.
    """

    def __init__(self) -> None:
        self.steps = 0
        self.strengths: dict[Direction, float] = {}
        self.counts: dict[Direction, int] = {}

    def add(self, estimate: MotionEstimate) -> None:
        """Count a step."""
        way = estimate.direction
        self.steps += 1
        self.counts[way] = self.counts.get(way, 0) + 1
        if way is not Direction.NONE:
            self.strengths[way] = self.strengths.get(way, 0.0) + estimate.strength

    @property
    def direction(self) -> Direction:
        """The verdict; none where no step named a direction."""
        return max(self.strengths, key=self.strengths.__getitem__, default=Direction.NONE)

    @property
    def share(self) -> float:
        """Its part in the strength of all, 0 to 1; 0 where it is none."""
        total = sum(self.strengths.values())
        return self.strengths[self.direction] / total if total else 0.0


@dataclass(frozen=True, eq=False)
class Picture:
    """What was seen at one moment.

    Attributes:
        estimate: what the detector then said; None where it said nothing.
        events: of the `PICTURE_US` before.
        frame: the last APS frame that had ended by then; None where there is none.
    """

    estimate: MotionEstimate | None
    events: Events
    frame: ApsFrame | None


class Curves:
    """What a figure shows, in some 60 bytes an estimate.

    Attributes:
        t_us, hs, vs, direction: of each estimate; the direction as its place in `Direction`.
        rate_us, on, off: of each piece: its end, and its events.
        picture: the moment of the strongest estimate that named a direction, else the last.
    """

    def __init__(self) -> None:
        self.t_us, self.rate_us = array("q"), array("q")
        self.hs, self.vs = array("f"), array("f")
        self.direction = array("b")
        self.on, self.off = array("l"), array("l")
        self.picture = Picture(None, empty_events(), None)
        self._strongest = 0.0
        self._recent = empty_events()
        self._frames: tuple[ApsFrame, ...] = ()

    def add(self, look: Look) -> None:
        """Take in a piece."""
        self._frames += look.frames
        if look.events.size:
            self._count(look.events)
        for estimate in look.estimates:
            self.t_us.append(estimate.t_us)
            self.hs.append(estimate.hs)
            self.vs.append(estimate.vs)
            self.direction.append(WAYS.index(estimate.direction))
            self._consider(estimate)
        # An estimate to come may be of a time before the frames that were seen last.
        self._frames = self._frames[-RECENT_FRAMES:]

    def _count(self, events: Events) -> None:
        on = int(np.count_nonzero(events["p"]))
        self.rate_us.append(int(events["t"][-1]))
        self.on.append(on)
        self.off.append(events.size - on)
        last_us = int(events["t"][-1])
        recent = joined([self._recent, events])
        # Twice the span: an estimate is of a time before the events that brought it.
        self._recent = recent[recent["t"] > last_us - 2 * PICTURE_US]
        if self._strongest == 0.0:
            self.picture = self._snapshot(None, last_us + 1)

    def _consider(self, estimate: MotionEstimate) -> None:
        if estimate.direction is not Direction.NONE and estimate.strength > self._strongest:
            self._strongest = estimate.strength
            self.picture = self._snapshot(estimate, estimate.t_us)

    def _snapshot(self, estimate: MotionEstimate | None, end_us: int) -> Picture:
        times_us = self._recent["t"]
        seen = (times_us >= end_us - PICTURE_US) & (times_us < end_us)
        ended = [frame for frame in self._frames if frame.end_us <= end_us]
        return Picture(estimate, self._recent[seen], ended[-1] if ended else None)

    def rates(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Times [s], and (2, n) ON and OFF events a second over 10 ms and longer spans."""
        if not self.rate_us:
            return np.zeros(0), np.zeros((2, 0))
        ends_us = np.asarray(self.rate_us)
        bin_us = max(10_000, int(np.ptp(ends_us)) // MOST_BINS)
        places, rows = np.unique(ends_us // bin_us, return_inverse=True)
        counts = np.zeros((2, int(np.ptp(places)) + 1 if places.size < MOST_BINS * 2 else 0))
        for row, values in enumerate((self.on, self.off)):
            np.add.at(counts[row], places[rows] - places[0], np.asarray(values))
        times_s = (places[0] + np.arange(counts.shape[1]) + 0.5) * bin_us * 1e-6
        return times_s, counts / (bin_us * 1e-6)


WAYS = tuple(Direction)
RECENT_FRAMES = 8
"""Frames that are kept for the picture (assumed: an estimate is some hops before the events that
brought it, and a frame is seldom shorter than a hop)."""
MOST_BINS = 2000
"""Points of the event rate in a figure (assumed: as many as there are pixels)."""
