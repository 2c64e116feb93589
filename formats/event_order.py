"""The order of events in time: checked, or restored within a window, or by dropping events."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from formats.columns import PARSED_DTYPE, Array, ReadOptions, joined
from formats.errors import FormatError

SORT_MAX_US = 10_000_000
"""Largest window within which events are sorted [µs]."""

_HELD_MAX = 1 << 23
"""Most events that are held to be sorted: 100 MB."""


class TimeOrder:
    """Makes the times of a stream of events non-decreasing, or refuses the first that is late.

    Attributes:
        sorted: number of events that came late and were put in order.
        dropped: number of events that were dropped.
    """

    def __init__(self, path: Path, options: ReadOptions) -> None:
        """Start a stream.

        Args:
            path: path of the file, for messages.
            options: whether late events are sorted, dropped or refused.
        """
        self.sorted = self.dropped = 0
        self._path = path
        self._window_us = options.sort_within_us
        self._drop = options.drop_unsorted
        self._done = 0
        self._latest_us: int | None = None
        self._held = np.empty(0, PARSED_DTYPE)
        self._unsure = np.empty(0, PARSED_DTYPE)
        self._before_us = self._latest_other_us = -(2**62)

    def push(self, events: Array) -> Iterator[Array]:
        """Yield events that no later ones can precede.

        Args:
            events: the next events of the file, at least one.

        Raises:
            FormatError: an event is late, and is neither to be sorted nor to be dropped. The events
                before it have been yielded.
        """
        if self._drop:
            events = self._without_leaps(joined([self._unsure, events]))
        if events.size:
            yield from self._in_order(events)

    def finish(self) -> Iterator[Array]:
        """Yield the events that are still held, at the end of the file or before an error."""
        if self._unsure.size:
            rest, self._unsure = self._unsure, self._unsure[:0]
            yield from self._in_order(rest)
        if self._held.size:
            yield self._held[np.argsort(self._held["t"], kind="stable")]
            self._held = self._held[:0]

    def _in_order(self, events: Array) -> Iterator[Array]:
        t = events["t"]
        before = self._latest_us if self._latest_us is not None else int(t[0])
        backwards = bool((t[1:] < t[:-1]).any()) or int(t[0]) < before
        if not backwards and not self._window_us:  # nearly every block of nearly every file
            self._latest_us, self._done = int(t[-1]), self._done + events.size
            yield events
            return
        latest = np.maximum.accumulate(np.concatenate([[before], t]))
        late_us = latest[:-1] - t
        too_late = late_us > self._window_us
        end = events.size
        if self._drop:
            self.dropped += int(np.count_nonzero(too_late))
        elif too_late.any():
            end = int(np.argmax(too_late))
        kept = ~too_late[:end]
        self.sorted += int(np.count_nonzero(kept & (late_us[:end] > 0)))
        self._latest_us = int(latest[end])
        yield from self._released(events[:end][kept])
        if end < events.size:
            yield from self.finish()
            raise self._late(self._done + end, int(t[end]), int(latest[end]))
        self._done += events.size

    def _released(self, events: Array) -> Iterator[Array]:
        """Hold events for the length of the window, and yield those that are older."""
        if not self._window_us:
            yield events
            return
        assert self._latest_us is not None
        held = joined([self._held, events])
        held = held[np.argsort(held["t"], kind="stable")]
        count = int(np.searchsorted(held["t"], self._latest_us - self._window_us))
        self._held = held[count:].copy()
        yield held[:count]
        if self._held.size > _HELD_MAX:
            raise FormatError(
                f"{self._path} has more than {_HELD_MAX} events within {self._window_us / 1e3:g} "
                "ms, which do not fit into memory to be sorted. Give a shorter time with --sort."
            )

    def _without_leaps(self, events: Array) -> Array:
        """Drop single events from the future, after which time falls back to where it was.

        The last event is kept back, because the one after it decides.
        """
        t = np.concatenate([[self._before_us], events["t"]])
        before, now, after = t[:-2], t[1:-1], t[2:]
        alone = (now - self._window_us > after) & (after >= before - self._window_us)
        others = np.where(alone, self._latest_other_us, now)
        latest = np.maximum.accumulate(np.concatenate([[self._latest_other_us], others]))
        leaps = alone & (after >= latest[:-1] - self._window_us)
        self.dropped += int(np.count_nonzero(leaps))
        self._before_us, self._latest_other_us = int(t[-2]), int(latest[-1])
        self._unsure = events[-1:].copy()
        return events[:-1][~leaps]

    def _late(self, number: int, t_us: int, latest_us: int) -> FormatError:
        late_ms = (latest_us - t_us) / 1e3
        return FormatError(
            f"{self._path}: event {number} has the time {t_us} µs, after one at {latest_us} µs. "
            "Times must not decrease. Sort events that are late by up to so many ms with --sort, "
            f"such as --sort {math.ceil(late_ms)}, or drop them with --drop-unsorted."
        )
