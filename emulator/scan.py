"""Which pixels have work in a step: those whose light has changed, and those whose event is due.

The others cost one comparison, made for many pixels at a time; a block whose light a caller knows
to be unchanged, and none of whose pixels is due, costs nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator._compile import compiled
from emulator.frames import MAX_LUMINANCE_CD_M2
from emulator.pixels import BLOCK, Floats, PixelState, Ticks

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

    look: npt.NDArray[np.bool_]
    changed: Masks
    due: Masks


def no_work(pixels: int) -> Work:
    """Arrays for a sensor of so many pixels, with every block to be looked at."""
    blocks = -(-pixels // BLOCK)
    return Work(np.ones(blocks, np.bool_), np.zeros(blocks, np.uint64), np.zeros(blocks, np.uint64))


def look_everywhere(work: Work) -> None:
    """Look at the light of every block."""
    work.look.fill(True)


def look_within(work: Work, window: tuple[int, int, int, int], width: int) -> None:
    """Look only at the blocks that a window touches.

    Args:
        work: changed in place.
        window: x0, y0, x1, y1 of the window, the last two exclusive [px].
        width: columns of the sensor [px].
    """
    x0, y0, x1, y1 = window
    work.look.fill(False)
    if x1 > x0:
        for row in range(y0, y1):
            work.look[(row * width + x0) // BLOCK : (row * width + x1 - 1) // BLOCK + 1] = True


@compiled
def find_changed(
    before: Words, after: Words, look: npt.NDArray[np.bool_], changed: Masks, first: int, last: int
) -> None:
    """Put masks of the pixels whose light has changed, bit by bit, into `changed`; NaN always has.

    A loop of constant length over a slice is what a compiler makes the most of.
    """
    for block in range(first, last):
        mask = np.uint64(0)
        if look[block]:
            old = before[block * BLOCK : (block + 1) * BLOCK]
            new = after[block * BLOCK : (block + 1) * BLOCK]
            difference = np.int32(0)
            if new.size == BLOCK:
                for i in range(BLOCK):
                    difference |= old[i] ^ new[i]
            if difference != 0 or new.size < BLOCK:
                for i in range(new.size):
                    mask |= np.uint64(old[i] != new[i]) << np.uint64(i)
        changed[block] = mask


@compiled
def find_due(
    wake_us: Ticks, block_wake_us: Ticks, due: Masks, first: int, last: int, to_us: np.int32
) -> None:
    """Put masks of the pixels whose time to wake is not after `to_us` into `due`."""
    for block in range(first, last):
        mask = np.uint64(0)
        if np.int32(block_wake_us[block] - to_us) <= 0:
            wake = wake_us[block * BLOCK : (block + 1) * BLOCK]
            if wake.size == BLOCK:
                for i in range(BLOCK):
                    mask |= np.uint64(np.int32(wake[i] - to_us) <= 0) << np.uint64(i)
            else:
                for i in range(wake.size):
                    mask |= np.uint64(np.int32(wake[i] - to_us) <= 0) << np.uint64(i)
        due[block] = mask


@compiled
def are_light(luminance: Floats, changed: Masks, first: int, last: int) -> bool:
    """Whether blocks that have changed can be light: no NaN, nothing negative or too bright."""
    valid = True
    for block in range(first, last):
        if changed[block]:
            light = luminance[block * BLOCK : (block + 1) * BLOCK]
            for i in range(light.size):
                valid &= (light[i] >= np.float32(0.0)) & (light[i] <= _MAX)
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
    wake_us, block_wake_us = state.wake_us, state.block_wake_us
    look, changed, due = work.look, work.changed, work.due
    blocks = look.size
    valid = True
    for first in range(part * GROUP, blocks, parts * GROUP):
        last = min(first + GROUP, blocks)
        find_changed(before, after, look, changed, first, last)
        find_due(wake_us, block_wake_us, due, first, last, np.int32(to_us))
        valid &= are_light(luminance, changed, first, last)
    return valid
