"""The queue of the arbiter: which pixels request, and which are held in reset."""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from flybench.portable_math import lowest_bit

INITIAL_SLOTS = 4096

BITS = 64
ONE = np.uint64(1)
NONE = -1
FREE, WAITS, HELD = np.uint8(0), np.uint8(1), np.uint8(2)

BUS_FREE_PS, LAST_LINE, SECOND, PENDING, VACANT, SLOTS, HELD_FIRST, HELD_LAST = range(8)
"""Positions in `Queue.marks`."""

Scalar = TypeVar("Scalar", bound=np.generic)

Longs = npt.NDArray[np.int64]
Ints = npt.NDArray[np.int32]


class Queue(NamedTuple):
    """State of the arbiter.

    Attributes:
        waits: (pixels,) state of each pixel: free, waiting, or held in reset.
        lines: (lines / 64,) bit set of the lines with requests.
        tree: (2·leaves,) request time of each node of the tree of arbiters, −1 for none [ps]; see
            `emulator.readout.arbiter_tree`.
        head: (lines,) first slot of the requests of each line, −1 for none.
        link: (slots,) next slot of the same line, or next vacant slot, −1 for none.
        key: (slots,) pixel and mark of a request, as in a key.
        since_us: (slots,) time at which the pixel fired [µs].
        release_us: (slots,) times at which held pixels are released, sorted [µs].
        release_pixel: (slots,) those pixels.
        marks: (8,) time until which the bus is busy [ps], line granted last, levels of the tree
            at which that is the second side of a visit, number of pending requests, first vacant
            slot, number of slots in use so far, position of the next release, end of the releases.
    """

    waits: npt.NDArray[np.uint8]
    lines: npt.NDArray[np.uint64]
    tree: Longs
    head: Ints
    link: Ints
    key: Longs
    since_us: Longs
    release_us: Longs
    release_pixel: Ints
    marks: Longs


@compiled
def request(queue: Queue, key: int, at_us: int, line: int) -> None:
    """Add the request of a pixel that has fired to its line."""
    marks = queue.marks
    slot = marks[VACANT]
    if slot == NONE:
        slot = marks[SLOTS]
        marks[SLOTS] += 1
    else:
        marks[VACANT] = queue.link[slot]
    queue.key[slot] = key
    queue.since_us[slot] = at_us
    queue.link[slot] = queue.head[line]
    queue.head[line] = slot
    queue.lines[line // BITS] |= ONE << np.uint64(line % BITS)
    marks[PENDING] += 1


@compiled
def next_in_turn(lines: npt.NDArray[np.uint64], last: int) -> int:
    """Return the first line with requests after `last`, cyclically; there must be one."""
    start = last + 1
    word = start // BITS
    bits = np.uint64(0)
    if word < lines.size:
        bits = (lines[word] >> np.uint64(start % BITS)) << np.uint64(start % BITS)
    while bits == 0:
        word = word + 1 if word + 1 < lines.size else 0
        bits = lines[word]
    return word * BITS + int(lowest_bit(bits))


@compiled
def release_pixels(queue: Queue, until_us: int) -> None:
    """Release the held pixels whose reset is over at `until_us`."""
    marks = queue.marks
    while marks[HELD_FIRST] < marks[HELD_LAST]:
        place = marks[HELD_FIRST]
        if queue.release_us[place] > until_us:
            break
        queue.waits[queue.release_pixel[place]] = FREE
        marks[HELD_FIRST] += 1


def empty_queue(pixels: int, lines: int) -> Queue:
    """Return the queue of a sensor of this many pixels and lines, without requests."""
    marks = np.zeros(8, np.int64)
    marks[LAST_LINE] = marks[VACANT] = NONE
    return Queue(
        waits=np.zeros(pixels, np.uint8),
        lines=np.zeros(-(-lines // BITS), np.uint64),
        tree=np.full(2 << (lines - 1).bit_length(), NONE, np.int64),
        head=np.full(lines, NONE, np.int32),
        link=np.empty(INITIAL_SLOTS, np.int32),
        key=np.empty(INITIAL_SLOTS, np.int64),
        since_us=np.empty(INITIAL_SLOTS, np.int64),
        release_us=np.empty(INITIAL_SLOTS, np.int64),
        release_pixel=np.empty(INITIAL_SLOTS, np.int32),
        marks=marks,
    )


def larger_queue(queue: Queue, slots: int) -> Queue:
    """Return the queue with this many slots."""
    return queue._replace(
        link=_longer(queue.link, slots),
        key=_longer(queue.key, slots),
        since_us=_longer(queue.since_us, slots),
        release_us=_longer(queue.release_us, slots),
        release_pixel=_longer(queue.release_pixel, slots),
    )


def _longer(array: npt.NDArray[Scalar], size: int) -> npt.NDArray[Scalar]:
    return np.concatenate((array, np.empty(size - array.size, array.dtype)))
