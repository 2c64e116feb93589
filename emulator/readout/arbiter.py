"""The row arbiter: all events leave the chip over one bus, row by row.

A pixel that fires requests its row. The arbiter grants the rows in turn, starting after the row
granted last, or from the top after a pause (assumed). The bus then carries the address of the row
and the columns of all pixels that request in it, word by word, and the events of the row get one
time stamp (Boahen, IEEE TCAS-II 47(5), 2000; the maker's documentation: about 12 million events
per second for the DAVIS346). Requests that wait are delayed. A pixel can wait with one event only,
and stays in reset until its refractory period has passed after the grant; events that it would
have fired in the meantime are lost.

Times are whole picoseconds from the first sample, so that precision does not fall with time.
Events that are not granted within their step are carried over to a later one.
"""

from __future__ import annotations

import numpy as np

from emulator.readout.arbiter_queue import (
    HELD_FIRST,
    HELD_LAST,
    INITIAL_SLOTS,
    PENDING,
    SLOTS,
    empty_queue,
    larger_queue,
)
from emulator.readout.arbitration import DELAYED, DROPPED, LONGEST_DELAY, Bus, arbitrate
from emulator.readout.event_keys import Keys
from emulator.readout.latency import FixedLatency
from emulator.readout.stats import ReadoutStats


class Arbiter:
    """Reads the events of a sensor row by row, step by step.

    Args:
        width: columns of the sensor [px].
        height: rows of the sensor [px].
        limit_hz: words per second that the bus carries [Hz].
        latency_us: time from a grant to its time stamp [µs].
        refractory_us: refractory period of the pixels [µs].
    """

    def __init__(
        self, *, width: int, height: int, limit_hz: float, latency_us: int, refractory_us: int
    ):
        self._bus = Bus(width, max(1, round(1e12 / limit_hz)), refractory_us)
        self._latency_us = latency_us
        self._queue = empty_queue(width * height, height)
        self._granted = np.empty(INITIAL_SLOTS, np.int64)
        self._latency = FixedLatency(latency_us)

    def read_out(self, keys: Keys, *, from_us: int, to_us: int) -> tuple[Keys, ReadoutStats]:
        """Read the events of one step out.

        Args:
            keys: (n,) events of the step, sorted.
            from_us: start of the step [µs from the first sample].
            to_us: end of the step [µs from the first sample].

        Returns:
            Events whose time stamps lie in the step, sorted; and counts of all events.
        """
        self._make_room(keys.size)
        tally = np.zeros(3, np.int64)
        count = arbitrate(self._queue, self._bus, keys, from_us, to_us, self._granted, tally)
        granted = self._granted[:count].copy()
        granted.sort()
        stamped = self._latency.stamp(granted, to_us - from_us)
        stats = ReadoutStats(
            offered=keys.size,
            delayed=int(tally[DELAYED]),
            dropped=int(tally[DROPPED]),
            waiting=int(self._queue.marks[PENDING]) + self._latency.waiting,
            delay_max_us=int(tally[LONGEST_DELAY]) + (self._latency_us if count else 0),
        )
        return stamped, stats

    def _make_room(self, new: int) -> None:
        """Make room for `new` events in the queue, and discard releases that are over."""
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
