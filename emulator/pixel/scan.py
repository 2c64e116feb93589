"""Which pixels have work in a step: those whose light has changed, and those whose event is due.

The others cost one comparison, made for many pixels at a time; a block whose light a caller knows
to be unchanged, and none of whose pixels is due, costs nothing.
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
"""Luminance as the words of memory that it takes."""

GROUP = 16
"""Neighbouring blocks that one thread takes on; threads take turns, so as to share busy regions."""

_MAX = np.float32(MAX_LUMINANCE_CD_M2)


class Work(NamedTuple):
    """What there is to do in a step; each field (blocks,).

    Attributes:
        look: whether the light of the block may have changed.
        changed: mask of the pixels whose light has changed.
        due: mask of the pixels that may fire even if it has not.
    """

    look: Flags
    changed: Masks
    due: Masks


def no_work(pixels: int) -> Work:
    """Arrays for a sensor of so many pixels, with every block to be looked at."""
    blocks = -(-pixels // BLOCK)
    return Work(np.ones(blocks, np.bool_), np.zeros(blocks, np.uint64), np.zeros(blocks, np.uint64))


def look_everywhere(look: Flags) -> None:
    """Look at the light of every block."""
    look.fill(True)


@compiled
def look_within(look: Flags, rectangle: tuple[int, int, int, int], width: int) -> None:
    """Look only at the blocks that a rectangle touches.

    Args:
        look: (blocks,) put out; see `Work`.
        rectangle: x0, y0, x1, y1 of the rectangle, the last two exclusive [px].
        width: columns of the sensor [px].
    """
    x0, y0, x1, y1 = rectangle
    look[:] = False
    if x1 > x0:
        for row in range(y0, y1):
            for block in range((row * width + x0) // BLOCK, (row * width + x1 - 1) // BLOCK + 1):
                look[block] = True


@inlined
def next_block(block: int, parts: int) -> int:
    """The block that a thread takes on after `block`."""
    return block + 1 if (block + 1) % GROUP else block + 1 + (parts - 1) * GROUP


@compiled
def find_changed(
    before: Words, after: Words, look: Flags, changed: Masks, part: int, parts: int
) -> None:
    """Put masks of the pixels whose light has changed, bit by bit, into `changed`; NaN always has.

    A compiler works on many pixels at a time if no index can be negative. Slices would be slower:
    each counts itself in and out of the users of its array, with an instruction that cores share.
    """
    block = part * GROUP
    while block < look.size:
        mask, first = np.uint64(0), np.uint64(block * BLOCK)
        if look[block]:
            for i in range(min(BLOCK, before.size - block * BLOCK)):
                place = first + np.uint64(i)
                mask |= np.uint64(before[place] != after[place]) << np.uint64(i)
        changed[block] = mask
        block = next_block(block, parts)


@compiled
def find_due(
    wake_us: Ticks, block_wake_us: Ticks, due: Masks, to_us: np.int32, part: int, parts: int
) -> None:
    """Put masks of the pixels whose time to wake is not after `to_us` into `due`."""
    block = part * GROUP
    while block < due.size:
        mask, first = np.uint64(0), np.uint64(block * BLOCK)
        if np.int32(block_wake_us[block] - to_us) <= 0:
            for i in range(min(BLOCK, wake_us.size - block * BLOCK)):
                awake = np.int32(wake_us[first + np.uint64(i)] - to_us) <= 0
                mask |= np.uint64(awake) << np.uint64(i)
        due[block] = mask
        block = next_block(block, parts)


@compiled
def are_light(luminance: Floats, changed: Masks, part: int, parts: int) -> bool:
    """Whether blocks that have changed can be light: no NaN, nothing negative or too bright."""
    valid = True
    block = part * GROUP
    while block < changed.size:
        if changed[block]:
            first = np.uint64(block * BLOCK)
            for i in range(min(BLOCK, luminance.size - block * BLOCK)):
                light = luminance[first + np.uint64(i)]
                valid &= (light >= np.float32(0.0)) & (light <= _MAX)
        block = next_block(block, parts)
    return valid


@compiled
def find_work(
    state: PixelState, luminance: Floats, to_us: int, work: Work, part: int, parts: int
) -> bool:
    """Find the work of one thread, and check the light that is new.

    Args:
        state: of all pixels, before the step.
        luminance: (pixels,) light at the end of the step [cd/m²].
        to_us: end of the step [µs from the first sample].
        work: `changed` and `due` are filled in, for the blocks of this thread.
        part: number of this thread, from 0.
        parts: how many threads there are.

    Returns:
        Whether all light is light. If not, `work` is of no use; `state` is as it was in any case.
    """
    before, after = state.luminance.view(np.int32), luminance.view(np.int32)
    find_changed(before, after, work.look, work.changed, part, parts)
    find_due(state.wake_us, state.block_wake_us, work.due, np.int32(to_us), part, parts)
    return are_light(luminance, work.changed, part, parts)
