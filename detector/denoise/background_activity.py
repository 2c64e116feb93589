"""The background-activity filter of T. Delbruck, "Frame-free dynamic digital vision", 2008.

An event is kept if one of its eight neighbours has fired shortly before, with any polarity. Events
of the pixel itself do not support it, so that a hot pixel is removed.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from detector.denoise.event_filter import F32, I64, NEVER_US, TIME_US, EventFilter, last_times
from detector.errors import DetectorConfigError
from flybench.events import Events
from flybench.kernels import compiled


class BackgroundActivityFilter(EventFilter):
    """Keeps events that have one supporter; the score is minus its age [µs]."""

    def __init__(self, *, width: int, height: int, tau_us: int = 30_000) -> None:
        """Start without events.

        Args:
            width: sensor columns [px].
            height: sensor rows [px].
            tau_us: greatest age of the supporter, 1 µs to 10 s [µs]. 30 ms is the default of jAER,
                the software of its author.

        Raises:
            DetectorConfigError: a value is out of range.
            MemoryBudgetError: the sensor is too large for the memory budget.
        """
        super().__init__(width=width, height=height)
        self._tau_us = TIME_US.check("tau_us", tau_us, DetectorConfigError)
        self._last = last_times(self, 1, 1)[0]

    @property
    def threshold(self) -> float:
        """Minus the greatest age [µs]."""
        return -float(self._tau_us)

    def scores(self, events: Events) -> F32:
        """Return minus the age of the latest event of the eight neighbours [µs]."""
        return _scores(events, self._last)


@compiled
def _scores(events: Any, last: I64) -> F32:
    scores = np.empty(len(events), np.float32)
    for n in range(len(events)):
        t, x, y = events[n].t, events[n].x + 1, events[n].y + 1
        own, last[y, x] = last[y, x], NEVER_US
        newest = NEVER_US
        for row in range(y - 1, y + 2):
            for column in range(x - 1, x + 2):
                newest = max(newest, last[row, column])
        scores[n] = newest - t if newest > NEVER_US else -np.inf
        last[y, x] = max(own, t)
    return scores
