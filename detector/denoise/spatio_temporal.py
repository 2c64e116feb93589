"""The spatio-temporal correlation filter (STCF).

S. Guo and T. Delbruck, "Low cost and latency event camera background activity denoising", IEEE
TPAMI 45 (1), 2023. An event is kept if at least k of its eight neighbours have fired shortly
before, with the same polarity.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from detector.denoise.event_filter import F32, I64, NEVER_US, TIME_US, EventFilter, last_times
from detector.errors import DetectorConfigError
from flybench.checks import Range
from flybench.events import Events
from flybench.kernels import compiled

_NEIGHBOURS = Range(1, 8)


class SpatioTemporalFilter(EventFilter):
    """Keeps events that have k supporters; the score is minus the age of the k-th latest [µs]."""

    def __init__(
        self, *, width: int, height: int, tau_us: int = 25_000, supporters: int = 2
    ) -> None:
        """Start without events.

        Args:
            width: sensor columns [px].
            height: sensor rows [px].
            tau_us: greatest age of a supporter, 1 µs to 10 s [µs]. 25 ms is the default of jAER,
                the software of its authors.
            supporters: k, least number of neighbours that have fired, 1 to 8; 2 is jAER's default.

        Raises:
            DetectorConfigError: a value is out of range.
            MemoryBudgetError: the sensor is too large for the memory budget.
        """
        super().__init__(width=width, height=height)
        self._tau_us = TIME_US.check("tau_us", tau_us, DetectorConfigError)
        self._supporters = _NEIGHBOURS.check("supporters", supporters, DetectorConfigError)
        self._last = last_times(self, 2, 1)

    @property
    def threshold(self) -> float:
        """Minus the greatest age [µs]."""
        return -float(self._tau_us)

    def scores(self, events: Events) -> F32:
        """Return minus the age of the k-th latest neighbour of the same polarity [µs]."""
        return _scores(events, self._last, self._supporters)


@compiled
def _scores(events: Any, last: I64, supporters: int) -> F32:
    scores = np.empty(len(events), np.float32)
    latest = np.empty(supporters, np.int64)
    for n in range(len(events)):
        t, x, y, p = events[n].t, events[n].x + 1, events[n].y + 1, int(events[n].p)
        latest[:] = NEVER_US
        for row in range(y - 1, y + 2):
            for column in range(x - 1, x + 2):
                if row != y or column != x:
                    _insert(latest, last[p, row, column])
        oldest = latest[supporters - 1]
        scores[n] = oldest - t if oldest > NEVER_US else -np.inf
        last[p, y, x] = t
    return scores


@compiled
def _insert(latest: I64, t: int) -> None:
    """Insert a time into a list of the latest times, latest first."""
    for k in range(len(latest)):
        if t > latest[k]:
            t, latest[k] = latest[k], t
