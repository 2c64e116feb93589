"""The time-surface filter.

X. Lagorce et al., "HOTS: a hierarchy of event-based time-surfaces for pattern recognition", IEEE
TPAMI 39 (7), 2017, define the surface: e^(−age/τ) of the last event of each pixel around an event,
of the same polarity. The filter keeps events with a high mean surface. Its parameters are those of
the benchmark of S. Ding et al., "E-MLB: multilevel benchmark for event-based camera denoising",
IEEE TMM 26, 2024. It takes the mean over the pixels that have fired at all; we take it over all
pixels of the neighbourhood, because the former depends on the length of the recording.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from detector.denoise.event_filter import F32, I64, NEVER_US, TIME_US, EventFilter, last_times
from detector.errors import DetectorConfigError
from flybench.checks import Range
from flybench.events import Events
from flybench.kernels import compiled

_RADIUS, _THRESHOLD = Range(1, 10, "px"), Range(0.0, 1.0)
_NEGLIGIBLE_TAUS = 20.0
"""Age in τ from which a surface counts as zero: e^−20 is below the precision of float32."""


class TimeSurfaceFilter(EventFilter):
    """Keeps events on a fresh surface; the score is its mean over the neighbourhood, 0 to 1."""

    def __init__(
        self,
        *,
        width: int,
        height: int,
        tau_us: int = 20_000,
        radius_px: int = 1,
        threshold: float = 0.2,
    ) -> None:
        """Start without events.

        Args:
            width: sensor columns [px].
            height: sensor rows [px].
            tau_us: time constant of the decay, 1 µs to 10 s [µs] (E-MLB).
            radius_px: half side of the square neighbourhood, 1 to 10 [px] (E-MLB).
            threshold: least mean surface, 0 to 1 (E-MLB).

        Raises:
            DetectorConfigError: a value is out of range.
            MemoryBudgetError: the sensor is too large for the memory budget.
        """
        super().__init__(width=width, height=height)
        self._tau_us = TIME_US.check("tau_us", tau_us, DetectorConfigError)
        self._radius = _RADIUS.check("radius_px", radius_px, DetectorConfigError)
        self._threshold = _THRESHOLD.check("threshold", threshold, DetectorConfigError)
        self._last = last_times(self, 2, self._radius)

    @property
    def threshold(self) -> float:
        """Least mean surface."""
        return float(self._threshold)

    def scores(self, events: Events) -> F32:
        """Return the mean surface of the pixels around each event, 0 to 1."""
        return _scores(events, self._last, float(self._tau_us), self._radius)


@compiled
def _scores(events: Any, last: I64, tau_us: float, radius: int) -> F32:
    scores = np.empty(len(events), np.float32)
    pixels = (2 * radius + 1) ** 2
    for n in range(len(events)):
        t, p = events[n].t, int(events[n].p)
        x, y = events[n].x + radius, events[n].y + radius
        total = 0.0
        for row in range(y - radius, y + radius + 1):
            for column in range(x - radius, x + radius + 1):
                then = last[p, row, column]
                age = (t - then) / tau_us if then > NEVER_US else np.inf
                if age < _NEGLIGIBLE_TAUS:
                    total += math.exp(-age)
        scores[n] = total / pixels
        last[p, y, x] = t
    return scores
