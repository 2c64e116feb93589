"""The kernels of the row arbiter; see `emulator.readout.arbiter`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from emulator.readout.arbiter_queue import (
    BITS,
    BUS_FREE_PS,
    FREE,
    HELD,
    HELD_FIRST,
    HELD_LAST,
    LAST_ROW,
    NONE,
    ONE,
    PENDING,
    VACANT,
    WAITS,
    Longs,
    Queue,
    next_row,
    release_pixels,
    request,
)
from emulator.readout.event_keys import LOW_BITS, PIXEL_MASK, TIME_SHIFT, Keys
from flybench.kernels import compiled

PS_PER_US = 1_000_000

DELAYED, DROPPED, LONGEST_DELAY = range(3)
"""Positions in the tally of a step."""


class Bus(NamedTuple):
    """Constants of the arbiter.

    Attributes:
        width: columns of the sensor [px].
        word_ps: time that one word takes on the bus [ps].
        refractory_us: refractory period of the pixels [µs].
    """

    width: int
    word_ps: int
    refractory_us: int


@compiled
def grant(
    queue: Queue,
    row: int,
    stamp_us: int,
    refractory_us: int,
    granted: Keys,
    count: int,
    tally: Longs,
) -> int:
    """Read a row out; a pixel that has waited is held until its reset is over.

    Args:
        queue: state of the arbiter; changed in place.
        row: the row.
        stamp_us: time of the grant [µs from the first sample].
        refractory_us: refractory period of the pixels [µs].
        granted: output array; the keys get no time yet.
        count: number of entries of `granted` in use.
        tally: counts of the step; changed in place.

    Returns:
        Number of entries of `granted` then in use.
    """
    marks, slot = queue.marks, np.int64(queue.head[row])
    while slot != NONE:
        pixel = (queue.key[slot] >> 3) & PIXEL_MASK
        delay_us = stamp_us - queue.since_us[slot]
        queue.waits[pixel] = FREE
        if delay_us > 0:
            tally[DELAYED] += 1
            tally[LONGEST_DELAY] = max(tally[LONGEST_DELAY], delay_us)
            queue.waits[pixel] = HELD
            queue.release_us[marks[HELD_LAST]] = stamp_us + refractory_us
            queue.release_pixel[marks[HELD_LAST]] = pixel
            marks[HELD_LAST] += 1
        granted[count] = queue.key[slot]
        count += 1
        following = np.int64(queue.link[slot])
        queue.link[slot] = marks[VACANT]
        marks[VACANT] = slot
        marks[PENDING] -= 1
        slot = following
    queue.head[row] = NONE
    queue.rows[row // BITS] &= ~(ONE << np.uint64(row % BITS))
    return count


@compiled
def pass_uncontended(
    keys: Keys, from_us: int, bus_free_ps: int, few: int, granted: Keys, taken: int, count: int
) -> int:
    """Grant the events of every microsecond in which the bus can carry all of them.

    Args:
        keys: (n,) events of the step, sorted.
        from_us: start of the step [µs from the first sample].
        bus_free_ps: time until which the bus is busy [ps].
        few: number of events that the bus carries within 1 µs even if each is in its own row.
        granted: output array for keys.
        taken: first event to look at.
        count: number of entries of `granted` in use.

    Returns:
        The first event of a microsecond with more events, or the number of events.
    """
    while taken < keys.size:
        offset_us = keys[taken] >> TIME_SHIFT
        after = taken + 1
        while after < keys.size and keys[after] >> TIME_SHIFT == offset_us:
            after += 1
        if after - taken > few or (from_us + offset_us) * PS_PER_US < bus_free_ps:
            break
        for k in range(taken, after):
            granted[count] = keys[k]
            count += 1
        taken = after
    return taken


@compiled
def enter_requests(
    queue: Queue,
    width: int,
    keys: Keys,
    taken: int,
    from_us: int,
    bus_free_ps: int,
    tally: Longs,
) -> int:
    """Add the requests of all pixels that fire before the bus is free; return the next event."""
    while taken < keys.size:
        at_us = from_us + (keys[taken] >> TIME_SHIFT)
        if at_us * PS_PER_US > bus_free_ps:
            break
        release_pixels(queue, at_us)
        low = keys[taken] & LOW_BITS
        pixel = low >> 3
        if queue.waits[pixel] == FREE:
            queue.waits[pixel] = WAITS
            request(queue, low, at_us, pixel // width)
        else:
            tally[DROPPED] += 1
        taken += 1
    return taken


@compiled
def arbitrate(
    queue: Queue, bus: Bus, keys: Keys, from_us: int, to_us: int, granted: Keys, tally: Longs
) -> int:
    """Run the arbiter through one step.

    Args:
        queue: state of the arbiter; changed in place.
        bus: constants of the arbiter.
        keys: (n,) events of the step, sorted.
        from_us: start of the step [µs from the first sample].
        to_us: end of the step [µs from the first sample].
        granted: output array for the keys of the events that are read out in the step.
        tally: (3,) events delayed, events dropped, longest delay [µs]; changed in place.

    Returns:
        Number of events read out; they are in the order of the grants.
    """
    marks = queue.marks
    bus_ps, end_ps = marks[BUS_FREE_PS], (to_us + 1) * PS_PER_US
    few = PS_PER_US // (2 * bus.word_ps)
    taken = count = 0
    while True:
        if marks[PENDING] == 0:
            marks[LAST_ROW] = NONE
            if marks[HELD_FIRST] == marks[HELD_LAST]:
                passed = pass_uncontended(keys, from_us, bus_ps, few, granted, taken, count)
                count += passed - taken
                taken = passed
            if taken == keys.size:
                break
            bus_ps = max(bus_ps, (from_us + (keys[taken] >> TIME_SHIFT)) * PS_PER_US)
        taken = enter_requests(queue, bus.width, keys, taken, from_us, bus_ps, tally)
        if marks[PENDING] == 0:
            continue
        if bus_ps >= end_ps:
            break
        row = next_row(queue.rows, marks[LAST_ROW])
        stamp_us = bus_ps // PS_PER_US
        before = count
        count = grant(queue, row, stamp_us, bus.refractory_us, granted, count, tally)
        for k in range(before, count):
            granted[k] |= (stamp_us - from_us) << TIME_SHIFT
        bus_ps += (1 + count - before) * bus.word_ps
        marks[LAST_ROW] = row
    marks[BUS_FREE_PS] = bus_ps
    return count
