"""T4 and T5: elementary motion detectors in the four cardinal directions.

A half-detector multiplies the delayed signal of one point with the present signal of another. The
two half-detectors of an axis share both points, with the delay exchanged (the arrangement of
Hassenstein and Reichardt). The paper prints the rightward one and leaves the rest to similarity;
this reading makes what flickers without moving cancel in every single pair, so that HS and VS stay
unbiased when a region of interest cuts through the object. For the same reason each pair is noted
at its midpoint, not at its delayed point as printed: the edge of a region then cuts the pairs of
opposite directions alike, and a mirrored stream gives mirrored responses.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

F32 = npt.NDArray[np.float32]

RIGHT, LEFT, UP, DOWN = range(4)
"""Planes of a stack of direction maps."""


def t4(on: F32, on_delayed: F32, *, spacing: int, count: int) -> F32:
    """T4: correlations in the ON pathway (paper, equation 9).

    Args:
        on: ON surface now, (rows, columns) float32.
        on_delayed: ON surface one delay earlier, same shape.
        spacing: sd, the shortest distance between the two points [cells].
        count: n_c, how many multiples of it are summed.

    Returns:
        (4, rows, columns) float32, planes right, left, up, down. Each pair is noted at its
        midpoint; where that lies between two cells, as with an odd distance, each takes half.
    """
    maps: F32 = _half_detectors(on, on_delayed, spacing, count)
    return maps


def t5(off: F32, off_delayed: F32, *, spacing: int, count: int) -> F32:
    """T5: the same correlations in the OFF pathway (paper, equation 9); see `t4`."""
    maps: F32 = _half_detectors(off, off_delayed, spacing, count)
    return maps


@njit(cache=True)
def _half_detectors(now: Any, delayed: Any, spacing: int, count: int) -> Any:
    rows, columns = now.shape
    maps = np.zeros((4, rows, columns), np.float32)
    half = np.float32(0.5)
    for i in range(spacing, spacing * count + 1, spacing):
        for middle in (i // 2, (i + 1) // 2):
            for y in range(rows):
                for x in range(columns - i):
                    maps[RIGHT, y, x + middle] += half * delayed[y, x] * now[y, x + i]
                    maps[LEFT, y, x + middle] += half * delayed[y, x + i] * now[y, x]
            for y in range(rows - i):
                for x in range(columns):
                    maps[DOWN, y + middle, x] += half * delayed[y, x] * now[y + i, x]
                    maps[UP, y + middle, x] += half * delayed[y + i, x] * now[y, x]
    return maps
