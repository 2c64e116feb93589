"""The kernels of the arbiter; see `emulator.readout.arbiter`."""

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
    LAST_LINE,
    NONE,
    ONE,
    PENDING,
    VACANT,
    WAITS,
    Longs,
    Queue,
    next_in_turn,
    release_pixels,
    request,
)
from emulator.readout.arbiter_tree import hand_up, next_in_tree, request_line
from emulator.readout.event_keys import LOW_BITS, PIXEL_MASK, TIME_SHIFT, Keys
from flybench.kernels import compiled

PS_PER_US = 1_000_000

DELAYED, DROPPED, LONGEST_DELAY = range(3)
"""Positions in the tally of a step."""


class Bus(NamedTuple):
    """Constants of the arbiter.

    Attributes:
        width: columns of the sensor [px].
        by_columns: True if the lines are the columns of the image, False if its rows.
        in_turn: True to grant the lines in their order, False to ask the tree.
        word_ps: time that one word takes on the bus [ps].
        line_ps: time to choose a line and to send its address [ps].
        refractory_us: refractory period of the pixels [µs].
    """

    width: int
    by_columns: bool
    in_turn: bool
    word_ps: int
    line_ps: int
    refractory_us: int


@compiled
def grant(
    queue: Queue,
    line: int,
    stamp_us: int,
    refractory_us: int,
    granted: Keys,
    count: int,
    tally: Longs,
) -> int:
    """Read a line out; a pixel that has waited is held until its reset is over.

    Args:
        queue: state of the arbiter; changed in place.
        line: the line.
        stamp_us: time of the grant [µs from the first sample].
        refractory_us: refractory period of the pixels [µs].
        granted: output array; the keys get no time yet.
        count: number of entries of `granted` in use.
        tally: counts of the step; changed in place.

    Returns:
        Number of entries of `granted` then in use.
    """
    marks, slot = queue.marks, np.int64(queue.head[line])
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
    queue.head[line] = NONE
    queue.lines[line // BITS] &= ~(ONE << np.uint64(line % BITS))
    queue.tree[(queue.tree.size >> 1) + line] = NONE
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
        few: number of events that the bus carries within 1 µs even if each is in its own line.
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
    bus: Bus,
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
            line = pixel % bus.width if bus.by_columns else pixel // bus.width
            request(queue, low, at_us, line)
            request_line(queue.tree, line, at_us * PS_PER_US)
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
    few = PS_PER_US // (bus.line_ps + bus.word_ps)
    taken = count = 0
    while True:
        if marks[PENDING] == 0:
            hand_up(queue.tree, marks, bus_ps)
            marks[LAST_LINE] = NONE
            if marks[HELD_FIRST] == marks[HELD_LAST]:
                passed = pass_uncontended(keys, from_us, bus_ps, few, granted, taken, count)
                count += passed - taken
                taken = passed
            if taken == keys.size:
                break
            bus_ps = max(bus_ps, (from_us + (keys[taken] >> TIME_SHIFT)) * PS_PER_US)
        taken = enter_requests(queue, bus, keys, taken, from_us, bus_ps, tally)
        if marks[PENDING] == 0:
            continue
        if bus_ps >= end_ps:
            break
        if bus.in_turn:
            line = next_in_turn(queue.lines, marks[LAST_LINE])
        else:
            line = next_in_tree(queue.tree, marks, bus_ps)
        stamp_us = bus_ps // PS_PER_US
        before = count
        count = grant(queue, line, stamp_us, bus.refractory_us, granted, count, tally)
        for k in range(before, count):
            granted[k] |= (stamp_us - from_us) << TIME_SHIFT
        bus_ps += bus.line_ps + (count - before) * bus.word_ps
        marks[LAST_LINE] = line
    marks[BUS_FREE_PS] = bus_ps
    return count
