"""The pixels that a step must compute: those whose luminance has changed or whose event is due.

Every other pixel costs one comparison, and many pixels are compared at a time. A block costs
nothing if the caller states that its luminance is unchanged and no pixel in it is due.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator.luminance_frames import MAX_LUMINANCE_CD_M2
from emulator.pixel.state import BLOCK, Floats, PixelState, Ticks
from flybench.kernels import compiled, inlined

Flags = npt.NDArray[np.bool_]
Masks = npt.NDArray[np.uint64]
Words = npt.NDArray[np.int32]
"""The 32-bit patterns of luminance values."""

GROUP = 16
"""Neighbouring blocks that one thread processes. The threads take turns, so that they share regions
with many active pixels."""

_MAX = np.float32(MAX_LUMINANCE_CD_M2)


class ActiveMasks(NamedTuple):
    """The active pixels of a step; all fields are (blocks,).

    Attributes:
        compare: True if the luminance of the block may have changed.
        changed: mask of the pixels whose luminance has changed.
        due: mask of the pixels that may fire even if their luminance has not changed.
    """

    compare: Flags
    changed: Masks
    due: Masks


class ThreadShare(NamedTuple):
    """The part of the blocks that one thread processes.

    Attributes:
        part: number of the thread, from 0.
        parts: number of threads.
    """

    part: int
    parts: int


def empty_masks(pixels: int) -> ActiveMasks:
    """Return masks for a sensor of this many pixels, with all blocks to be compared."""
    blocks = -(-pixels // BLOCK)
    return ActiveMasks(
        np.ones(blocks, np.bool_), np.zeros(blocks, np.uint64), np.zeros(blocks, np.uint64)
    )


def mark_all_blocks(compare: Flags) -> None:
    """Mark all blocks for comparison."""
    compare.fill(True)


@compiled
def mark_blocks_within(compare: Flags, rectangle: tuple[int, int, int, int], width: int) -> None:
    """Mark only the blocks for comparison that a rectangle touches.

    Args:
        compare: (blocks,) output array; see `ActiveMasks`.
        rectangle: x0, y0, x1, y1 of the rectangle, the last two exclusive [px].
        width: columns of the sensor [px].
    """
    x0, y0, x1, y1 = rectangle
    compare[:] = False
    if x1 > x0:
        for row in range(y0, y1):
            for block in range((row * width + x0) // BLOCK, (row * width + x1 - 1) // BLOCK + 1):
                compare[block] = True


@inlined
def next_block(block: int, parts: int) -> int:
    """Return the block that a thread processes after `block`."""
    return block + 1 if (block + 1) % GROUP else block + 1 + (parts - 1) * GROUP


@compiled
def find_changed(before: Words, after: Words, masks: ActiveMasks, share: ThreadShare) -> None:
    """Find the pixels whose luminance has changed, bit by bit; NaN counts as a change.

    The compiler processes many pixels at a time only if no index can be negative. Slices would be
    slower: the reference count of their array is changed by an instruction that all cores share.

    Args:
        before: (pixels,) luminance at the start of the step.
        after: (pixels,) luminance at the end of the step.
        masks: `changed` is set in the blocks of this thread.
        share: blocks of this thread.
    """
    compare, changed = masks.compare, masks.changed
    block = share.part * GROUP
    while block < compare.size:
        mask, first = np.uint64(0), np.uint64(block * BLOCK)
        if compare[block]:
            for i in range(min(BLOCK, before.size - block * BLOCK)):
                place = first + np.uint64(i)
                mask |= np.uint64(before[place] != after[place]) << np.uint64(i)
        changed[block] = mask
        block = next_block(block, share.parts)


@compiled
def find_due(
    wake_us: Ticks, block_wake_us: Ticks, to_us: np.int32, masks: ActiveMasks, share: ThreadShare
) -> None:
    """Find the pixels whose wake time is not after `to_us`; `masks.due` is set."""
    due = masks.due
    block = share.part * GROUP
    while block < due.size:
        mask, first = np.uint64(0), np.uint64(block * BLOCK)
        if np.int32(block_wake_us[block] - to_us) <= 0:
            for i in range(min(BLOCK, wake_us.size - block * BLOCK)):
                awake = np.int32(wake_us[first + np.uint64(i)] - to_us) <= 0
                mask |= np.uint64(awake) << np.uint64(i)
        due[block] = mask
        block = next_block(block, share.parts)


@compiled
def is_valid(luminance: Floats, changed: Masks, share: ThreadShare) -> bool:
    """Return True if every luminance in blocks with changes is valid: not NaN, and in range."""
    valid = True
    block = share.part * GROUP
    while block < changed.size:
        if changed[block]:
            first = np.uint64(block * BLOCK)
            for i in range(min(BLOCK, luminance.size - block * BLOCK)):
                value = luminance[first + np.uint64(i)]
                valid &= (value >= np.float32(0.0)) & (value <= _MAX)
        block = next_block(block, share.parts)
    return valid


@compiled
def find_active(
    state: PixelState, luminance: Floats, to_us: int, masks: ActiveMasks, share: ThreadShare
) -> bool:
    """Find the active pixels in the blocks of one thread, and check the new luminance.

    Args:
        state: state of all pixels before the step.
        luminance: (pixels,) luminance at the end of the step [cd/m²].
        to_us: end of the step [µs from the first sample].
        masks: `changed` and `due` are set in the blocks of this thread.
        share: blocks of this thread.

    Returns:
        True if every luminance is valid. If not, the masks must not be used. `state` is not
        changed.
    """
    before, after = state.luminance.view(np.int32), luminance.view(np.int32)
    find_changed(before, after, masks, share)
    find_due(state.wake_us, state.block_wake_us, np.int32(to_us), masks, share)
    return is_valid(luminance, masks.changed, share)
