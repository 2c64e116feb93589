"""The queue of the row arbiter: which pixels request, and which are held in reset."""

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

BUS_FREE_PS, LAST_ROW, PENDING, VACANT, SLOTS, HELD_FIRST, HELD_LAST = range(7)
"""Positions in `Queue.marks`."""

Scalar = TypeVar("Scalar", bound=np.generic)

Longs = npt.NDArray[np.int64]
Ints = npt.NDArray[np.int32]


class Queue(NamedTuple):
    """State of the arbiter.

    Attributes:
        waits: (pixels,) state of each pixel: free, waiting, or held in reset.
        rows: (rows / 64,) bit set of the rows with requests.
        head: (rows,) first slot of the requests of each row, −1 for none.
        link: (slots,) next slot of the same row, or next vacant slot, −1 for none.
        key: (slots,) pixel and mark of a request, as in a key.
        since_us: (slots,) time at which the pixel fired [µs].
        release_us: (slots,) times at which held pixels are released, sorted [µs].
        release_pixel: (slots,) those pixels.
        marks: (7,) time until which the bus is busy [ps], row granted last, number of pending
            requests, first vacant slot, number of slots in use so far, position of the next
            release, end of the releases.
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
    """Add the request of a pixel that has fired to its row."""
    marks = queue.marks
    slot = marks[VACANT]
    if slot == NONE:
        slot = marks[SLOTS]
        marks[SLOTS] += 1
    else:
        marks[VACANT] = queue.link[slot]
    queue.key[slot] = key
    queue.since_us[slot] = at_us
    queue.link[slot] = queue.head[row]
    queue.head[row] = slot
    queue.rows[row // BITS] |= ONE << np.uint64(row % BITS)
    marks[PENDING] += 1


@compiled
def next_row(rows: npt.NDArray[np.uint64], last: int) -> int:
    """Return the first row with requests after `last`, cyclically; there must be one."""
    start = last + 1
    word = start // BITS
    bits = np.uint64(0)
    if word < rows.size:
        bits = (rows[word] >> np.uint64(start % BITS)) << np.uint64(start % BITS)
    while bits == 0:
        word = word + 1 if word + 1 < rows.size else 0
        bits = rows[word]
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


def empty_queue(pixels: int, rows: int) -> Queue:
    """Return the queue of a sensor of this many pixels and rows, without requests."""
    marks = np.zeros(7, np.int64)
    marks[LAST_ROW] = marks[VACANT] = NONE
    return Queue(
        waits=np.zeros(pixels, np.uint8),
        rows=np.zeros(-(-rows // BITS), np.uint64),
        head=np.full(rows, NONE, np.int32),
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
