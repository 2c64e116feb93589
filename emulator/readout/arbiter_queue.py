"""The arbiter's queue, and the kernel that works it off; see `emulator.readout.arbiter`."""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from emulator.readout.event_keys import PIXEL_MASK, TIME_SHIFT, Keys
from flybench.kernels import compiled
from flybench.portable_math import lowest_bit

PS_PER_US = 1_000_000

_BITS = 64
_ONE = np.uint64(1)
_NONE = -1
LOW_BITS = (1 << TIME_SHIFT) - 1
ROOM_AT_FIRST = 4096
_FREE, _WAITS, _HELD = np.uint8(0), np.uint8(1), np.uint8(2)
BUS, ROW, PENDING, VACANT, SLOTS, HELD_FIRST, HELD_LAST = range(7)
DELAYED, DROPPED, WORST = range(3)

Scalar = TypeVar("Scalar", bound=np.generic)

Longs = npt.NDArray[np.int64]
Ints = npt.NDArray[np.int32]


class Queue(NamedTuple):
    """What the arbiter remembers.

    Attributes:
        waits: (pixels,) whether a pixel is free, waits, or is held in reset.
        rows: (rows / 64,) bit set of rows with requests.
        head: (rows,) first slot of each row's requests, −1 for none.
        link: (slots,) next slot of the same row, or next vacant one, −1 for none.
        key: (slots,) pixel and mark of a request, as in a key.
        since_us: (slots,) time of its event.
        release_us: (slots,) times at which held pixels are let go, in order.
        release_pixel: (slots,) those pixels.
        marks: time until which the bus is taken [ps], row granted last, requests pending, first
            vacant slot, slots in use so far, first release to come, end of the releases.
    """

    waits: npt.NDArray[np.uint8]
    rows: npt.NDArray[np.uint64]
    head: Ints
    link: Ints
    key: Longs
    since_us: Longs
    release_us: Longs
    release_pixel: Ints
    marks: Longs


@compiled
def request(queue: Queue, key: int, at_us: int, row: int) -> None:
    """Enter the request of a pixel with an event into its row."""
    marks = queue.marks
    slot = marks[VACANT]
    if slot == _NONE:
        slot = marks[SLOTS]
        marks[SLOTS] += 1
    else:
        marks[VACANT] = queue.link[slot]
    queue.key[slot] = key
    queue.since_us[slot] = at_us
    queue.link[slot] = queue.head[row]
    queue.head[row] = slot
    queue.rows[row // _BITS] |= _ONE << np.uint64(row % _BITS)
    marks[PENDING] += 1


@compiled
def next_row(rows: npt.NDArray[np.uint64], last: int) -> int:
    """First row with requests after `last`, in turn; there must be one."""
    start = last + 1
    word = start // _BITS
    bits = np.uint64(0)
    if word < rows.size:
        bits = (rows[word] >> np.uint64(start % _BITS)) << np.uint64(start % _BITS)
    while bits == 0:
        word = word + 1 if word + 1 < rows.size else 0
        bits = rows[word]
    return word * _BITS + int(lowest_bit(bits))


@compiled
def let_go(queue: Queue, until_us: int) -> None:
    """Free the held pixels whose time has come; times are in order."""
    marks = queue.marks
    while marks[HELD_FIRST] < marks[HELD_LAST]:
        place = marks[HELD_FIRST]
        if queue.release_us[place] > until_us:
            break
        queue.waits[queue.release_pixel[place]] = _FREE
        marks[HELD_FIRST] += 1


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
    """Read a row out: its pixels are let go, at once or when held until their reset is over.

    Returns:
        How many of `granted`, (time, pixel, mark) as keys without their first time, are in use.
    """
    marks, slot = queue.marks, np.int64(queue.head[row])
    while slot != _NONE:
        pixel = (queue.key[slot] >> 3) & PIXEL_MASK
        delay_us = stamp_us - queue.since_us[slot]
        queue.waits[pixel] = _FREE
        if delay_us > 0:
            tally[DELAYED] += 1
            tally[WORST] = max(tally[WORST], delay_us)
            queue.waits[pixel] = _HELD
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
    queue.head[row] = _NONE
    queue.rows[row // _BITS] &= ~(_ONE << np.uint64(row % _BITS))
    return count


@compiled
def pass_calm(
    keys: Keys, from_us: int, bus_ps: int, few: int, granted: Keys, taken: int, count: int
) -> int:
    """Grant events, from `taken` on, of microseconds so calm that all leave within them.

    Args:
        keys: events of the step, sorted.
        from_us: start of the step [µs from the first sample].
        bus_ps: time until which the bus is taken [ps].
        few: events of one microsecond that the bus surely carries in it, each in a row of its own.
        granted: room for keys.
        taken: first event to look at.
        count: how many of `granted` are in use.

    Returns:
        The first event of a microsecond that is not calm, or the number of events.
    """
    while taken < keys.size:
        offset_us = keys[taken] >> TIME_SHIFT
        after = taken + 1
        while after < keys.size and keys[after] >> TIME_SHIFT == offset_us:
            after += 1
        if after - taken > few or (from_us + offset_us) * PS_PER_US < bus_ps:
            break
        for k in range(taken, after):
            granted[count] = keys[k]
            count += 1
        taken = after
    return taken


@compiled
def arbitrate(
    queue: Queue,
    keys: Keys,
    from_us: int,
    to_us: int,
    width: int,
    word_ps: int,
    refractory_us: int,
    granted: Keys,
    tally: Longs,
) -> int:
    """Run the arbiter through one step.

    Args:
        queue: what it remembers; changed in place.
        keys: (n,) events of the step, sorted.
        from_us: start of the step [µs from the first sample].
        to_us: its end.
        width: columns of the sensor [px].
        word_ps: time that one word takes on the bus [ps].
        refractory_us: refractory period [µs].
        granted: room for the keys of the events that are read out in the step.
        tally: events offered, delayed and dropped, and the worst delay [µs]; changed in place.

    Returns:
        How many events were read out; in the order of the grants.
    """
    marks = queue.marks
    bus_ps, end_ps = marks[BUS], (to_us + 1) * PS_PER_US
    few = PS_PER_US // (2 * word_ps)
    taken = count = 0
    while True:
        if marks[PENDING] == 0:
            marks[ROW] = _NONE
            if marks[HELD_FIRST] == marks[HELD_LAST]:
                passed = pass_calm(keys, from_us, bus_ps, few, granted, taken, count)
                count += passed - taken
                taken = passed
            if taken == keys.size:
                break
            bus_ps = max(bus_ps, (from_us + (keys[taken] >> TIME_SHIFT)) * PS_PER_US)
        while taken < keys.size:
            at_us = from_us + (keys[taken] >> TIME_SHIFT)
            if at_us * PS_PER_US > bus_ps:
                break
            let_go(queue, at_us)
            low = keys[taken] & LOW_BITS
            pixel = low >> 3
            if queue.waits[pixel] == _FREE:
                queue.waits[pixel] = _WAITS
                request(queue, low, at_us, pixel // width)
            else:
                tally[DROPPED] += 1
            taken += 1
        if marks[PENDING] == 0:
            continue
        if bus_ps >= end_ps:
            break
        row = next_row(queue.rows, marks[ROW])
        stamp_us = bus_ps // PS_PER_US
        before = count
        count = grant(queue, row, stamp_us, refractory_us, granted, count, tally)
        for k in range(before, count):
            granted[k] |= (stamp_us - from_us) << TIME_SHIFT
        bus_ps += (1 + count - before) * word_ps
        marks[ROW] = row
    marks[BUS] = bus_ps
    return count


def empty_queue(pixels: int, rows: int) -> Queue:
    """Queue of a sensor of so many pixels and rows, without requests."""
    marks = np.zeros(7, np.int64)
    marks[ROW] = marks[VACANT] = _NONE
    return Queue(
        waits=np.zeros(pixels, np.uint8),
        rows=np.zeros(-(-rows // _BITS), np.uint64),
        head=np.full(rows, _NONE, np.int32),
        link=np.empty(ROOM_AT_FIRST, np.int32),
        key=np.empty(ROOM_AT_FIRST, np.int64),
        since_us=np.empty(ROOM_AT_FIRST, np.int64),
        release_us=np.empty(ROOM_AT_FIRST, np.int64),
        release_pixel=np.empty(ROOM_AT_FIRST, np.int32),
        marks=marks,
    )


def _longer(array: npt.NDArray[Scalar], size: int) -> npt.NDArray[Scalar]:
    return np.concatenate((array, np.empty(size - array.size, array.dtype)))


def larger_queue(queue: Queue, slots: int) -> Queue:
    """The same queue with so many slots."""
    return queue._replace(
        link=_longer(queue.link, slots),
        key=_longer(queue.key, slots),
        since_us=_longer(queue.since_us, slots),
        release_us=_longer(queue.release_us, slots),
        release_pixel=_longer(queue.release_pixel, slots),
    )
