"""The order of events in time: checked, or restored within a window, or by dropping events."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from formats.columns import (
    PARSED_DTYPE,
    Array,
    EventColumns,
    ParsedArray,
    ParsedFrame,
    ParsedItem,
    ReadOptions,
    Size,
    joined,
    to_events,
    valid_length,
)
from formats.errors import FormatError
from formats.samples import ParsedSamples

SORT_MAX_US = 10_000_000
"""Largest window within which events are sorted [µs]."""

_HELD_MAX = 1 << 23
"""Most events that are held to be sorted: 100 MB."""

_WAITING_MAX_BYTES = 1 << 28
"""Most memory for the frames that wait for held events [bytes]."""

_END_US = 2**62
"""Time after all events [µs]."""


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
        self._waiting: deque[tuple[int, ParsedFrame | ParsedSamples]] = deque()
        self._waiting_bytes = 0
        self._before_us = self._latest_other_us = -_END_US

    def push(self, events: Array) -> Iterator[ParsedArray]:
        """Yield events that no later ones can precede, and what waited for them.

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

    def push_other(self, item: ParsedFrame | ParsedSamples) -> Iterator[ParsedArray]:
        """Yield a frame or samples, or keep them until the events before them are yielded.

        Raises:
            FormatError: the frames that wait do not fit into memory.
        """
        if not self._window_us or self._latest_us is None:
            yield item
            return
        self._waiting.append((self._latest_us, item))
        self._waiting_bytes += _frame_bytes(item)
        if self._waiting_bytes > _WAITING_MAX_BYTES:
            raise self._too_many(f"{_WAITING_MAX_BYTES >> 20} MB of frames")

    def finish(self) -> Iterator[ParsedArray]:
        """Yield all that is still held, at the end of the file or before an error."""
        if self._unsure.size:
            rest, self._unsure = self._unsure, self._unsure[:0]
            yield from self._in_order(rest)
        held, self._held = self._held, self._held[:0]
        yield from self._with_waiting(held[np.argsort(held["t"], kind="stable")], _END_US)

    def _in_order(self, events: Array) -> Iterator[ParsedArray]:
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

    def _released(self, events: Array) -> Iterator[ParsedArray]:
        """Hold events for the length of the window, and yield those that are older."""
        if not self._window_us:
            yield events
            return
        assert self._latest_us is not None
        held = joined([self._held, events])
        held = held[np.argsort(held["t"], kind="stable")]
        until_us = self._latest_us - self._window_us
        count = int(np.searchsorted(held["t"], until_us))
        self._held = held[count:].copy()
        yield from self._with_waiting(held[:count], until_us)
        if self._held.size > _HELD_MAX:
            raise self._too_many(f"{_HELD_MAX} events")

    def _with_waiting(self, events: Array, until_us: int) -> Iterator[ParsedArray]:
        """Yield sorted events, and between them what came after events before `until_us`."""
        while self._waiting and self._waiting[0][0] < until_us:
            after_us, item = self._waiting.popleft()
            self._waiting_bytes -= _frame_bytes(item)
            count = int(np.searchsorted(events["t"], after_us, side="right"))
            yield events[:count]
            yield item
            events = events[count:]
        yield events

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

    def _too_many(self, what: str) -> FormatError:
        return FormatError(
            f"{self._path} has more than {what} within {self._window_us / 1e3:g} ms, which do not "
            "fit into memory to be sorted. Give a shorter time with --sort."
        )

    def _late(self, number: int, t_us: int, latest_us: int) -> FormatError:
        late_ms = (latest_us - t_us) / 1e3
        return FormatError(
            f"{self._path}: event {number} has the time {t_us} µs, after one at {latest_us} µs. "
            "Times must not decrease. Sort events that are late by up to so many ms with --sort, "
            f"such as --sort {math.ceil(late_ms)}, or drop them with --drop-unsorted."
        )


def _frame_bytes(item: ParsedFrame | ParsedSamples) -> int:
    return item.image.nbytes if isinstance(item, ParsedFrame) else 0


def valid_in_order(
    path: Path,
    items: Iterator[ParsedItem],
    size: Size,
    order: TimeOrder,
    *,
    size_is_option: bool,
) -> Iterator[ParsedArray]:
    """Yield frames, samples, and valid events in order; before an error, all events before it."""
    done = 0
    try:
        for item in items:
            if not isinstance(item, EventColumns):
                yield from order.push_other(item)
                continue
            valid, error = valid_length(
                item, size, path=path, done=done, size_is_option=size_is_option
            )
            done += valid
            if valid:
                yield from order.push(to_events(item.first(valid)))
            if error is not None:
                raise error
    except GeneratorExit:
        raise
    except BaseException:
        yield from order.finish()
        raise
    yield from order.finish()
