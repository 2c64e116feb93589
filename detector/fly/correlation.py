"""T4 and T5: elementary motion detectors in the four cardinal directions.

A half-detector multiplies the delayed signal of one point with the present signal of another. The
two half-detectors of an axis share both points, with the delay exchanged (the arrangement of
Hassenstein and Reichardt). The paper prints the rightward one and leaves the rest to similarity;
this reading makes what flickers without moving cancel in every single pair, so that HS and VS stay
unbiased when a region of interest cuts through the object. For the same reason each pair is noted
at its midpoint, unless it is asked for at its delayed point as printed: the edge of a region then
cuts the pairs of opposite directions alike, and a mirrored stream gives mirrored responses.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.fly.model_variants import PairLocation
from flybench.kernels import compiled

F32 = npt.NDArray[np.float32]

RIGHT, LEFT, UP, DOWN = range(4)
"""Planes of a stack of direction maps."""


def t4(
    on: F32,
    on_delayed: F32,
    *,
    offsets: Sequence[int],
    pair_location: PairLocation = PairLocation.MIDPOINT,
) -> F32:
    """T4: correlations in the ON pathway (paper, equation 9).

    Args:
        on: ON surface now, (rows, columns) float32.
        on_delayed: delayed ON surface, same shape.
        offsets: i, the distances between the two points that are summed over [cells].
        pair_location: to which cell a pair belongs.

    Returns:
        (4, rows, columns) float32, planes right, left, up, down. Where a midpoint lies between two
        cells, as with an odd distance, each takes half.
    """
    at_delayed = pair_location is PairLocation.DELAYED
    maps: F32 = _half_detectors(on, on_delayed, np.array(offsets, np.int64), at_delayed)
    return maps


def t5(
    off: F32,
    off_delayed: F32,
    *,
    offsets: Sequence[int],
    pair_location: PairLocation = PairLocation.MIDPOINT,
) -> F32:
    """T5: the same correlations in the OFF pathway (paper, equation 9); see `t4`."""
    return t4(off, off_delayed, offsets=offsets, pair_location=pair_location)


@compiled
def _half_detectors(now: Any, delayed: Any, offsets: Any, at_delayed: bool) -> Any:
    """Sum over the offsets; `ahead` is where the pair of a point and one further on is noted."""
    maps = np.zeros((4, *now.shape), np.float32)
    for i in offsets:
        if at_delayed:
            _add_pairs(maps, now, delayed, i, 0, i, np.float32(1.0))
        elif i % 2 == 0:
            _add_pairs(maps, now, delayed, i, i // 2, i // 2, np.float32(1.0))
        else:
            _add_pairs(maps, now, delayed, i, i // 2, i // 2, np.float32(0.5))
            _add_pairs(maps, now, delayed, i, i // 2 + 1, i // 2 + 1, np.float32(0.5))
    return maps


@compiled
def _add_pairs(
    maps: Any, now: Any, delayed: Any, i: int, forward_at: int, backward_at: int, share: Any
) -> None:
    """Add the pairs at distance i, noted that far after their first point, to the maps."""
    rows, columns = now.shape
    for y in range(rows):
        right, left = maps[RIGHT, y, forward_at:], maps[LEFT, y, backward_at:]
        near_now, near_delayed = now[y], delayed[y]
        far_now, far_delayed = now[y, i:], delayed[y, i:]
        for x in range(columns - i):
            right[x] += share * (near_delayed[x] * far_now[x])
            left[x] += share * (far_delayed[x] * near_now[x])
    for y in range(rows - i):
        down, up = maps[DOWN, y + forward_at], maps[UP, y + backward_at]
        near_now, near_delayed = now[y], delayed[y]
        far_now, far_delayed = now[y + i], delayed[y + i]
        for x in range(columns):
            down[x] += share * (near_delayed[x] * far_now[x])
            up[x] += share * (far_delayed[x] * near_now[x])
