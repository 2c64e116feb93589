"""Slices of a sequence: the events before or after each label."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.events import EVENT_DTYPE, Events
from scenarios.errors import ScenarioError

I64 = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Slicing:
    """Which events belong to a label. Exactly one of the first two fields is set.

    Attributes:
        window_us: length of the slice [µs].
        count: number of events of the slice.
        after: False: the slice ends before the label's time; True: it starts at that time.
        history_us: time before the slice whose events are read as well [µs].

    Raises:
        ScenarioError: none or both of the lengths are given, or one is not positive.
    """

    window_us: int | None = None
    count: int | None = None
    after: bool = False
    history_us: int = 0

    def __post_init__(self) -> None:
        lengths = [length for length in (self.window_us, self.count) if length is not None]
        if len(lengths) != 1 or lengths[0] < 1:
            raise ScenarioError(
                f"window_us is {self.window_us!r} and count is {self.count!r}. Allowed is one of "
                "them, 1 or more. Give window_us for slices of equal time, or count for slices of "
                "equal numbers of events."
            )

    def bounds(self, file: Any, label_us: int) -> tuple[int, int] | None:
        """Return the first event of a slice, and the first one after it.

        Args:
            file: open events.h5.
            label_us: time of the label [µs].

        Returns:
            Two indices; None if the sequence is too short for the slice.
        """
        if self.count is not None:
            at = first_event_at(file, label_us)
            start, end = (at, at + self.count) if self.after else (at - self.count, at)
            return (start, end) if start >= 0 and end <= len(file["events/t"]) else None
        start_us, end_us = self.window(label_us)
        if start_us - self.history_us < 0 or end_us > last_us(file):
            return None
        return first_event_at(file, start_us - self.history_us), first_event_at(file, end_us)

    def window(self, label_us: int) -> tuple[int, int]:
        """Return the half-open window of a label, for slices of equal time [µs]."""
        length_us = self.window_us or 0
        return (label_us, label_us + length_us) if self.after else (label_us - length_us, label_us)


def last_us(file: Any) -> int:
    """Return the time up to which the index of a file reaches [µs]."""
    return (len(file["ms_to_idx"]) - 1) * 1000


def first_event_at(file: Any, t_us: int) -> int:
    """Return the number of events before a time; the index of milliseconds narrows the search.

    Args:
        file: open events.h5.
        t_us: time, at most `last_us` [µs].
    """
    ms, rest_us = divmod(t_us, 1000)
    first = int(file["ms_to_idx"][ms])
    if rest_us == 0:
        return first
    last = int(file["ms_to_idx"][ms + 1])
    return first + int(np.searchsorted(file["events/t"][first:last], t_us))


def read_events(file: Any, start: int, end: int) -> Events:
    """Return events of a file as an array of `EVENT_DTYPE`."""
    events = np.empty(end - start, EVENT_DTYPE)
    for name in "txyp":
        events[name] = file[f"events/{name}"][start:end]
    return events
