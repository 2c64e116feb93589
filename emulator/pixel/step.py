"""All event pixels through one step: the hot loop of the emulator.

Only the active pixels are computed: those whose luminance has changed or whose next event is due
(`emulator.pixel.active_pixels`). They are followed in batches (`emulator.pixel.batch`), and their
crossings are computed in batches (`emulator.pixel.threshold_crossings`), as long as they have one
event at most. The others are computed one by one (`emulator.pixel.batch_events`,
`emulator.pixel.single_pixel`).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from emulator.pixel.active_pixels import GROUP, ActiveMasks, ThreadShare, next_block
from emulator.pixel.batch import Batch, follow_batch, gather, rounded_up
from emulator.pixel.batch_events import step_others, store_finished
from emulator.pixel.fields import BATCH
from emulator.pixel.noisy.batch import follow_quiet
from emulator.pixel.noisy.fire_batch import solve_events
from emulator.pixel.noisy.near_batch import solve_near
from emulator.pixel.noisy.step import step_noisy
from emulator.pixel.noisy.wake_batch import bring_to_ramp
from emulator.pixel.state import BLOCK, PixelModel, PixelState, StepTimes
from emulator.pixel.threshold_crossings import solve_crossings
from emulator.readout.event_keys import Keys
from flybench.kernels import compiled
from flybench.portable_math import lowest_bit

_ONE = np.uint64(1)


@compiled
def doubled(keys: Keys, most: int) -> Keys:
    """Return an array of twice the size with the keys at its start.

    Raises:
        MemoryError: that would be more than `most` keys.
    """
    if 2 * keys.size > most:
        raise MemoryError("too many events")
    larger = np.empty(2 * keys.size, np.int64)
    for k in range(keys.size):
        larger[k] = keys[k]
    return larger


@compiled
def fill_batch(masks: ActiveMasks, block: int, parts: int, batch: Batch) -> tuple[int, int]:
    """Collect active pixels, block by block, as long as the next block certainly fits.

    Args:
        masks: active pixels.
        block: block at which to begin.
        parts: number of threads that take turns in groups of blocks.
        batch: changed in place.

    Returns:
        The block at which to continue, and the number of pixels in the batch.
    """
    changed, due, indices, changes = masks.changed, masks.due, batch.indices, batch.changed
    count = 0
    while block < changed.size and count <= BATCH - BLOCK:
        mask = changed[block]
        while mask:
            indices[count] = block * BLOCK + int(lowest_bit(mask))
            changes[count] = True
            count += 1
            mask &= mask - _ONE
        mask = due[block] & ~changed[block]
        while mask:
            indices[count] = block * BLOCK + int(lowest_bit(mask))
            changes[count] = False
            count += 1
            mask &= mask - _ONE
        block = next_block(block, parts)
    return block, count


@compiled
def update_block_wake(
    state: PixelState, masks: ActiveMasks, to_us: np.int32, share: ThreadShare
) -> None:
    """Update the earliest wake time of each block of a thread that had active pixels."""
    wake_us, block_wake_us = state.wake_us, state.block_wake_us
    block, changed, due = share.part * GROUP, masks.changed, masks.due
    while block < changed.size:
        if changed[block] | due[block]:
            first, soonest = np.uint64(block * BLOCK), np.int32(2**30)
            for i in range(min(BLOCK, wake_us.size - block * BLOCK)):
                soonest = min(soonest, np.int32(wake_us[first + np.uint64(i)] - to_us))
            block_wake_us[block] = np.int32(soonest + to_us)
        block = next_block(block, share.parts)


@compiled
def step_pixels(
    state: PixelState,
    model: PixelModel,
    luminance: npt.NDArray[np.float32],
    times: StepTimes,
    masks: ActiveMasks,
    share: ThreadShare,
    batch: Batch,
    keys: Keys,
    most: int,
) -> tuple[Keys, int]:
    """Take the pixels of one thread through one step.

    Args:
        state: state of all pixels; changed in place.
        model: constants of the sensor.
        luminance: (pixels,) luminance at the end of the step [cd/m²].
        times: start and end of the step.
        masks: active pixels, from `find_active`.
        share: blocks of this thread.
        batch: an empty batch.
        keys: output array for the keys of the events.
        most: largest size of that array.

    Returns:
        The array of the keys, replaced by a larger one if necessary; and the number of entries in
        use.

    Raises:
        MemoryError: there are too many events; the state is half changed.
    """
    used = 0
    noisy = model.sigma_0 > 0.0
    simple = (not noisy) & (model.follower_us == 0.0)
    span_us = np.float64(times.to_us - times.from_us)
    block, blocks = share.part * GROUP, masks.changed.size
    while block < blocks:
        block, count = fill_batch(masks, block, share.parts, batch)
        gather(state, model, luminance, times.from_us, batch, count)
        if simple:
            follow_batch(batch.fields, model, rounded_up(count), span_us)
            solve_crossings(batch, model, count, span_us)
        else:
            if noisy:
                bring_to_ramp(batch, state, model, count, span_us)
            follow_quiet(batch, model, rounded_up(count), span_us)
            firing = solve_near(batch, model, count, span_us)
            solve_events(batch, state, model, firing, span_us)
        if keys.size - used < BATCH:
            keys = doubled(keys, most)
        used = store_finished(state, luminance, times, batch, count, noisy, keys, used)
        done = 0
        while done < count:
            if noisy:
                done, used = step_noisy(
                    state, model, luminance, times, batch, done, count, keys, used
                )
            else:
                done, used = step_others(
                    state, model, luminance, times, batch, done, count, keys, used
                )
            if done < count:
                keys = doubled(keys, most)
    update_block_wake(state, masks, np.int32(times.to_us), share)
    return keys, used
