"""The interface of all filters, and the memory of when each pixel fired last."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import numpy.typing as npt

from detector.errors import DetectorConfigError
from flybench.checks import Range
from flybench.events import Events
from flybench.memory import count_memory

F32 = npt.NDArray[np.float32]
I64 = npt.NDArray[np.int64]

NEVER_US = -(1 << 62)
"""Time of the last event of a pixel that has not fired yet [µs]."""
TIME_US = Range(1, 10_000_000, "µs")
"""Allowed times of the filters."""
_SIDE = Range(1, 32_767, "px")


class EventFilter(ABC):
    """A filter on one stream of one sensor, which comes in chunks of any size.

    Every event gets a score that grows with the evidence that it is signal. The filter keeps the
    events whose score reaches its threshold. Cuts between chunks change nothing.

    Attributes:
        width: sensor columns [px].
        height: sensor rows [px].
    """

    def __init__(self, *, width: int, height: int) -> None:
        """Check the size of the sensor.

        Raises:
            DetectorConfigError: a side is out of range.
        """
        self.width = _SIDE.check("width", width, DetectorConfigError)
        self.height = _SIDE.check("height", height, DetectorConfigError)

    @property
    @abstractmethod
    def threshold(self) -> float:
        """Lowest score of an event that the filter keeps."""

    @abstractmethod
    def scores(self, events: Events) -> F32:
        """Return the scores of the next events of the stream.

        Args:
            events: (n,) of `EVENT_DTYPE`, sorted by t, not before those passed earlier.

        Returns:
            (n,) float32; −∞ where there is no evidence at all.
        """

    def keep(self, events: Events) -> Events:
        """Return those of the next events of the stream that the filter keeps."""
        return events[self.scores(events) >= self.threshold]


def last_times(owner: EventFilter, planes: int, margin: int) -> I64:
    """Return (planes, height, width) times of the last events, `NEVER_US`, with a margin around.

    Args:
        owner: the filter, whose memory is counted.
        planes: number of planes, such as one for each polarity.
        margin: number of rows and columns to add on each side [px].

    Raises:
        MemoryBudgetError: the sensor is too large for the memory budget.
    """
    shape = planes, owner.height + 2 * margin, owner.width + 2 * margin
    what = f"A filter for {owner.width}×{owner.height} px"
    count_memory(owner, what, 8 * shape[0] * shape[1] * shape[2])
    return np.full(shape, NEVER_US, np.int64)
