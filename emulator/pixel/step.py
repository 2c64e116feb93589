"""All event pixels through one step of light: the hot loop of the emulator.

A pixel is worked on only where its light has changed or where its next event is due (see
`emulator.pixel.scan`). Those are followed in batches (`emulator.pixel.batch`), and their crossings
found in batches (`emulator.pixel.threshold_crossings`), as long as they have one event at most; the
others go their way one by one (`emulator.pixel.batch_return`, `emulator.pixel.single_pixel`).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from emulator.pixel.batch import (
    BATCH,
    Batch,
    follow_batch,
    gather,
    rounded_up,
)
from emulator.pixel.batch_return import finish_batch, return_followed
from emulator.pixel.scan import GROUP, Work, next_block
from emulator.pixel.state import BLOCK, PixelModel, PixelState, Ticks
from emulator.pixel.threshold_crossings import solve_crossings
from emulator.readout.event_keys import Keys
from flybench.kernels import compiled
from flybench.portable_math import lowest_bit

_ONE = np.uint64(1)


@compiled
def doubled(keys: Keys) -> Keys:
    """Array of twice the size with the same keys at its start."""
    larger = np.empty(2 * keys.size, np.int64)
    larger[: keys.size] = keys
    return larger


@compiled
def fill_batch(work: Work, block: int, parts: int, batch: Batch) -> tuple[int, int]:
    """Collect pixels that have work, block after block, as long as the next block's have room.

    Args:
        work: which pixels have work.
        block: block to begin with.
        parts: how many threads take turns in groups of blocks.
        batch: changed in place.

    Returns:
        The block to go on with, and how many pixels the batch holds.
    """
    changed, due, places, changes = work.changed, work.due, batch.places, batch.changed
    count = 0
    while block < changed.size and count <= BATCH - BLOCK:
        mask = changed[block]
        while mask:
            places[count] = block * BLOCK + int(lowest_bit(mask))
            changes[count] = True
            count += 1
            mask &= mask - _ONE
        mask = due[block] & ~changed[block]
        while mask:
            places[count] = block * BLOCK + int(lowest_bit(mask))
            changes[count] = False
            count += 1
            mask &= mask - _ONE
        block = next_block(block, parts)
    return block, count


@compiled
def set_block_wake(
    wake_us: Ticks, block_wake_us: Ticks, work: Work, to_us: np.int32, part: int, parts: int
) -> None:
    """Note the earliest time to wake of each block of a thread that had work."""
    block, changed, due = part * GROUP, work.changed, work.due
    while block < changed.size:
        if changed[block] | due[block]:
            first, soonest = np.uint64(block * BLOCK), np.int32(2**30)
            for i in range(min(BLOCK, wake_us.size - block * BLOCK)):
                soonest = min(soonest, np.int32(wake_us[first + np.uint64(i)] - to_us))
            block_wake_us[block] = np.int32(soonest + to_us)
        block = next_block(block, parts)


@compiled
def step_pixels(
    state: PixelState,
    model: PixelModel,
    luminance: npt.NDArray[np.float32],
    from_us: int,
    to_us: int,
    work: Work,
    part: int,
    parts: int,
    batch: Batch,
    keys: Keys,
) -> tuple[Keys, int]:
    """Take the pixels of one thread through one step of light.

    Args:
        state: of all pixels; changed in place.
        model: constants of the sensor.
        luminance: (pixels,) light at the end of the step [cd/m²].
        from_us: start of the step [µs from the first sample].
        to_us: its end.
        work: which pixels have work, from `find_work`.
        part: number of this thread, from 0.
        parts: how many threads there are.
        batch: room for a batch.
        keys: array to put the events' keys in.

    Returns:
        The keys, in a larger array where need be, and how many are in use.
    """
    used = 0
    span_us = np.float64(to_us - from_us)
    block, blocks = part * GROUP, work.changed.size
    while block < blocks:
        block, count = fill_batch(work, block, parts, batch)
        gather(state.pixels, state.luminance, luminance, from_us, batch.places, count, batch.fields)
        follow_batch(batch.fields, model, rounded_up(count), span_us)
        solve_crossings(batch, model, count, span_us)
        if keys.size - used < BATCH:
            keys = doubled(keys)
        used = return_followed(state, luminance, to_us - from_us, to_us, batch, count, keys, used)
        done = 0
        while done < count:
            done, used = finish_batch(
                state, model, luminance, from_us, to_us, batch, done, count, keys, used
            )
            if done < count:
                keys = doubled(keys)
    set_block_wake(state.wake_us, state.block_wake_us, work, np.int32(to_us), part, parts)
    return keys, used
