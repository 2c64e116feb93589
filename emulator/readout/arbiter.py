"""The arbiter: all events leave the chip over one bus, line by line.

A pixel that fires requests its line, a row or a column of the image. The arbiter chooses one of the
lines that wait (`emulator.readout.arbiter_tree`). The bus then carries the address of the line and
the places of all pixels that request in it, word by word, and the events of the line get one time
stamp (Boahen, IEEE TCAS-II 47(5), 2000; the maker's documentation: about 12 million events per
second for the DAVIS346). Requests that wait are delayed. A pixel can wait with one event only, and
stays in reset until its refractory period has passed after the grant; events that it would have
fired in the meantime are lost.

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
from emulator.readout.config import Lines, ReadoutConfig, ReadoutKind
from emulator.readout.event_keys import Keys
from emulator.readout.latency import FixedLatency
from emulator.readout.stats import ReadoutStats


class Arbiter:
    """Reads the events of a sensor line by line, step by step.

    Args:
        width: columns of the sensor [px].
        height: rows of the sensor [px].
        config: the readout; its kind is not `SCAN`.
        refractory_us: refractory period of the pixels [µs].
    """

    def __init__(self, *, width: int, height: int, config: ReadoutConfig, refractory_us: int):
        by_columns = config.lines is Lines.COLUMNS
        word_ps = max(1, round(1e12 / config.limit_hz))
        self._bus = Bus(
            width=width,
            by_columns=by_columns,
            in_turn=config.kind is ReadoutKind.ROUND_ROBIN,
            word_ps=word_ps,
            line_ps=config.line_words * word_ps,
            refractory_us=refractory_us,
        )
        self._latency_us = config.latency_us
        self._queue = empty_queue(width * height, width if by_columns else height)
        self._granted = np.empty(INITIAL_SLOTS, np.int64)
        self._latency = FixedLatency(config.latency_us)

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
