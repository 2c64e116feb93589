"""The double-window filter (DWF).

S. Guo and T. Delbruck, "Low cost and latency event camera background activity denoising", IEEE
TPAMI 45 (1), 2023. Two windows hold the last events that were taken for signal and for noise. An
event is signal if at least k events of both windows together are within the distance σ, |Δx| +
|Δy|. Then it enters the window of signal, else that of noise. Times and polarities are not used.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from detector.denoise.event_filter import F32, EventFilter
from detector.errors import DetectorConfigError
from flybench.checks import Range
from flybench.events import Events
from flybench.kernels import compiled

I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]

_LENGTH, _SIGMA, _NEIGHBOURS = Range(2, 100_000), Range(0, 65_534, "px"), Range(1, 64)
_FAR = 1 << 20
"""Coordinate of an empty place in a window: farther than any distance on a sensor [px]."""


class DoubleWindowFilter(EventFilter):
    """Keeps events near others; the score is minus the distance of the k-th nearest [px].

    What the windows hold depends on `sigma_px`, so a ROC curve needs one filter for each value.
    """

    def __init__(
        self,
        *,
        width: int,
        height: int,
        length: int = 512,
        sigma_px: int = 5,
        supporters: int = 1,
    ) -> None:
        """Start with empty windows.

        Args:
            width: sensor columns [px].
            height: sensor rows [px].
            length: number of events in both windows together, 2 to 100 000; half of them in each.
                512, and the two defaults below, are those of jAER, the software of its authors.
            sigma_px: greatest distance of a supporter [px].
            supporters: k, least number of events within that distance, 1 to 64.

        Raises:
            DetectorConfigError: a value is out of range.
        """
        super().__init__(width=width, height=height)
        length = _LENGTH.check("length", length, DetectorConfigError)
        self._sigma_px = _SIGMA.check("sigma_px", sigma_px, DetectorConfigError)
        self._supporters = _NEIGHBOURS.check("supporters", supporters, DetectorConfigError)
        self._windows = np.full((2, 2, length // 2), _FAR, np.int32)
        self._next = np.zeros(2, np.int64)

    @property
    def threshold(self) -> float:
        """Minus the greatest distance [px]."""
        return -float(self._sigma_px)

    def scores(self, events: Events) -> F32:
        """Return minus the distance of the k-th nearest event of the windows [px]."""
        return _scores(events, self._windows, self._next, self._sigma_px, self._supporters)


@compiled
def _scores(events: Any, windows: I32, places: I64, sigma_px: int, supporters: int) -> F32:
    """Score events and enter them into the windows.

    Args:
        events: the events.
        windows: (2, 2, length) windows of noise and of signal; x and y of their events.
        places: (2,) place of the next event in each window.
        sigma_px: greatest distance of a supporter [px].
        supporters: least number of supporters.
    """
    scores = np.empty(len(events), np.float32)
    nearest = np.empty(supporters, np.int64)
    length = windows.shape[2]
    for n in range(len(events)):
        x, y = events[n].x, events[n].y
        nearest[:] = _FAR
        for window in range(2):
            for k in range(length):
                distance = abs(windows[window, 0, k] - x) + abs(windows[window, 1, k] - y)
                if distance < nearest[supporters - 1]:
                    _insert(nearest, distance)
        farthest = nearest[supporters - 1]
        scores[n] = -farthest if farthest < _FAR else -np.inf
        taken_for = 1 if farthest <= sigma_px else 0
        windows[taken_for, 0, places[taken_for]] = x
        windows[taken_for, 1, places[taken_for]] = y
        places[taken_for] = (places[taken_for] + 1) % length
    return scores


@compiled
def _insert(nearest: I64, distance: int) -> None:
    """Insert a distance into a list of the least distances, least first."""
    for k in range(len(nearest)):
        if distance < nearest[k]:
            distance, nearest[k] = nearest[k], distance
