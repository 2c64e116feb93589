"""Statistics of the events at each pixel: intervals, alternation, predecessors, edges.

One pass over the events keeps for each pixel the time of its last event of either polarity, and its
current run. All other state is counters, so memory does not grow with the recording.

- An **interval** lies between successive events of a pixel, of any polarity.
- An event **has a predecessor** if its pixel had an event of its polarity in the last 30 ms.
- A **run** is a series of events of one polarity at a pixel, each at most 30 ms after the one
  before, without an event of the other polarity between them.
- An **edge** is a run with an event less than 5 ms before or after an event of the same polarity at
  one of the eight neighbours. Edges reach neighbours together; noise does not.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.events import Events
from flybench.kernels import compiled, inlined
from scenarios.event_statistics.interval_histogram import BINS, interval_bin

PREDECESSOR_US = 30_000
"""Longest interval to a predecessor, and inside a run [µs]: the time constant of the paper's time
surface (Fu et al., Table I)."""
COINCIDENCE_US = 5_000
"""Time within which an edge reaches a neighbour [µs] (assumed: it moves at 200 px/s or more, or
along the neighbour)."""
MAX_RUN = 255
"""Longest run that has its own entry in the histogram of runs; longer ones are counted as this."""

NO_POLARITY = -1
_NEVER_US = -(1 << 60)
_SAME, _CHANGED = 0, 1

I64 = npt.NDArray[np.int64]


class PixelHistory:
    """Counters of a recording, updated block by block.

    Attributes:
        counts: (2, rows, columns) number of OFF and of ON events of each pixel.
        changes: (rows, columns) number of events whose polarity is not that of the one before.
        intervals: (2, BINS) histogram of intervals to an event of the same polarity, and of the
            other one.
    """

    def __init__(self, *, width: int, height: int) -> None:
        self.counts = np.zeros((2, height, width), np.int64)
        self.changes = np.zeros((height, width), np.int64)
        self.intervals = np.zeros((2, BINS), np.int64)
        self._with_predecessor = np.zeros(1, np.int64)
        self._closed_runs = np.zeros((2, MAX_RUN + 1), np.int64)
        padded = (height + 2, width + 2)  # a margin of one pixel, so that all have eight neighbours
        self._last_us = np.full((2, *padded), _NEVER_US, np.int64)
        self._polarity = np.full(padded, NO_POLARITY, np.int8)
        self._run_length = np.zeros(padded, np.int32)
        self._is_edge = np.zeros(padded, np.bool_)

    def add(self, events: Events) -> None:
        """Include events, sorted by time and none older than those before."""
        state = (self._last_us, self._polarity, self._run_length, self._is_edge)
        counters = (self.counts, self.changes, self.intervals)
        _add(events, state, counters, self._with_predecessor, self._closed_runs)

    @property
    def with_predecessor(self) -> int:
        """Number of events that have a predecessor."""
        return int(self._with_predecessor[0])

    @property
    def runs(self) -> I64:
        """(2, MAX_RUN + 1) number of runs by length: those that are no edges, and edges."""
        runs = self._closed_runs.copy()
        is_open = self._run_length > 0
        lengths = np.minimum(self._run_length[is_open], MAX_RUN)
        np.add.at(runs, (self._is_edge[is_open].astype(int), lengths), 1)
        return runs


@compiled
def _add(events: Any, state: Any, counters: Any, with_predecessor: Any, runs: Any) -> None:
    last_us, polarity, run_length, is_edge = state
    counts, changes, intervals = counters
    for n in range(events.size):
        event = events[n]
        t, p, y, x = event.t, int(event.p), event.y + 1, event.x + 1
        counts[p, y - 1, x - 1] += 1
        before = polarity[y, x]
        since_us = t - max(last_us[0, y, x], last_us[1, y, x])
        if before != NO_POLARITY:
            change = _CHANGED if before != p else _SAME
            intervals[change, interval_bin(since_us)] += 1
            changes[y - 1, x - 1] += change
        with_predecessor[0] += t - last_us[p, y, x] <= PREDECESSOR_US
        if before != p or since_us > PREDECESSOR_US:
            if before != NO_POLARITY:
                runs[int(is_edge[y, x]), min(run_length[y, x], MAX_RUN)] += 1
            run_length[y, x], is_edge[y, x] = 0, False
        run_length[y, x] += 1
        polarity[y, x], last_us[p, y, x] = p, t
        _mark_edges(t, p, y, x, state)


@inlined
def _mark_edges(t: int, p: int, y: int, x: int, state: Any) -> None:
    """Mark the runs of an event and of its neighbours as edges if the events are close in time."""
    last_us, polarity, _, is_edge = state
    for j in range(y - 1, y + 2):
        for i in range(x - 1, x + 2):
            if (j != y or i != x) and t - last_us[p, j, i] < COINCIDENCE_US:
                is_edge[y, x] = True
                if polarity[j, i] == p:
                    is_edge[j, i] = True
