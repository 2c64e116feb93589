"""The row arbiter: all events leave the chip over one bus, row by row.

A pixel that has an event requests its row. The arbiter grants one row after another, in turn from
the last, or from the top after a pause (assumed); the bus then carries the row's address and the
columns of all pixels that request in it, word by word, and the events of the row get one time
stamp (Boahen, IEEE TCAS-II 47(5), 2000; the maker's documentation: about 12 million events a
second for the DAVIS346). What waits is delayed. A pixel can wait with one event only, and is held
in reset until its refractory period has passed after the grant; what it would have fired in the
meantime is lost.

Time runs in whole picoseconds from the first sample, so that hours are as exact as the start. An
event that is not granted within its step is carried over, and leaves in a later one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emulator.readout.arbiter_queue import (
    DELAYED,
    DROPPED,
    HELD_FIRST,
    HELD_LAST,
    LOW_BITS,
    PENDING,
    ROOM_AT_FIRST,
    SLOTS,
    WORST,
    arbitrate,
    empty_queue,
    larger_queue,
)
from emulator.readout.event_keys import TIME_SHIFT, Keys


@dataclass(frozen=True, kw_only=True)
class Readout:
    """What the arbiter did with the events of one step.

    Attributes:
        offered: events that pixels had in the step.
        delayed: events granted at least 1 µs after the pixel's event.
        dropped: events lost because their pixel still waited or was held in reset.
        waiting: events carried over, at the end of the step.
        delay_max_us: longest delay of an event of the output, the latency included [µs].
    """

    offered: int = 0
    delayed: int = 0
    dropped: int = 0
    waiting: int = 0
    delay_max_us: int = 0


class Latency:
    """Stamps events a fixed time after their grant; a bus without a limit does nothing else.

    Args:
        latency_us: from a grant to its stamp [µs].
    """

    def __init__(self, latency_us: int):
        self._latency_us = latency_us
        self._late = np.empty(0, np.int64)

    @property
    def waiting(self) -> int:
        """Events granted whose stamps lie in a later step."""
        return self._late.size

    def read_out(self, keys: Keys, *, from_us: int, to_us: int) -> tuple[Keys, Readout]:
        """Take the events of a step in, and grant each at its own time.

        Args:
            keys: (n,) events of the step, sorted.
            from_us: start of the step [µs from the first sample].
            to_us: its end.

        Returns:
            Events whose stamps lie in the step, sorted, and what happened to all of them.
        """
        stamped = self.stamp(keys, to_us - from_us)
        worst = self._latency_us if stamped.size else 0
        return stamped, Readout(offered=keys.size, waiting=self.waiting, delay_max_us=worst)

    def stamp(self, granted: Keys, step_us: int) -> Keys:
        """Add the latency, and keep for later steps what it pushes beyond the end of this one.

        What is kept has its time from the start of the next step.
        """
        if self._latency_us == 0:
            return granted
        last = (step_us << TIME_SHIFT) | LOW_BITS
        latency = self._latency_us << TIME_SHIFT
        old = int(np.searchsorted(self._late, last, "right"))
        new = int(np.searchsorted(granted, last - latency, "right"))
        stamped = np.concatenate((self._late[:old], granted[:new] + latency))
        late = (
            self._late[old:] - (step_us << TIME_SHIFT),
            granted[new:] - (step_us << TIME_SHIFT) + latency,
        )
        self._late = np.concatenate(late)
        return stamped


class Arbiter:
    """Reads the events of a sensor out, step by step.

    Args:
        width: columns of the sensor [px].
        height: rows of the sensor [px].
        limit_hz: words a second that the bus carries [Hz].
        latency_us: from a grant to its stamp [µs].
        refractory_us: refractory period of the pixels [µs].
    """

    def __init__(
        self, *, width: int, height: int, limit_hz: float, latency_us: int, refractory_us: int
    ):
        self._width = width
        self._word_ps = max(1, round(1e12 / limit_hz))
        self._latency_us = latency_us
        self._refractory_us = refractory_us
        self._queue = empty_queue(width * height, height)
        self._granted = np.empty(ROOM_AT_FIRST, np.int64)
        self._latency = Latency(latency_us)

    def read_out(self, keys: Keys, *, from_us: int, to_us: int) -> tuple[Keys, Readout]:
        """Take the events of a step in.

        Args:
            keys: (n,) events of the step, sorted.
            from_us: start of the step [µs from the first sample].
            to_us: its end.

        Returns:
            Events whose stamps lie in the step, sorted, and what happened to all of them.
        """
        self._make_room(keys.size)
        tally = np.zeros(4, np.int64)
        count = arbitrate(
            self._queue,
            keys,
            from_us,
            to_us,
            self._width,
            self._word_ps,
            self._refractory_us,
            self._granted,
            tally,
        )
        granted = self._granted[:count].copy()
        granted.sort()
        stamped = self._latency.stamp(granted, to_us - from_us)
        readout = Readout(
            offered=keys.size,
            delayed=int(tally[DELAYED]),
            dropped=int(tally[DROPPED]),
            waiting=int(self._queue.marks[PENDING]) + self._latency.waiting,
            delay_max_us=int(tally[WORST]) + (self._latency_us if count else 0),
        )
        return stamped, readout

    def _make_room(self, new: int) -> None:
        """See that the queue has room for `new` events, and forget releases that are over."""
        queue, marks = self._queue, self._queue.marks.tolist()
        first, last = marks[HELD_FIRST], marks[HELD_LAST]
        held = last - first
        if first > 0:
            for array in (queue.release_us, queue.release_pixel):
                array[:held] = array[first:last]
            queue.marks[HELD_FIRST], queue.marks[HELD_LAST] = 0, held
        needed = max(marks[SLOTS] + new, held + marks[PENDING] + new)
        if needed > queue.link.size:
            self._queue = larger_queue(queue, 2 * needed)
        if self._granted.size < needed:
            self._granted = np.empty(2 * needed, np.int64)
