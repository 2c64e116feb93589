"""T4 and T5: elementary motion detectors in the four cardinal directions.

A half-detector multiplies the delayed signal of one point with the present signal of another. The
two half-detectors of an axis share both points and exchange the delay (the arrangement of
Hassenstein and Reichardt). The paper prints only the rightward half-detector and leaves the
others to analogy. In this arrangement, the responses to flicker without motion cancel in every
pair, so that HS and VS stay unbiased if a region of interest cuts through the object.

For the same reason a pair belongs to the cell at its midpoint by default, not to its delayed point
as printed. The edge of a region then cuts the pairs of opposite directions alike, and a mirrored
stream gives mirrored responses.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from detector.fly.model_variants import PairLocation, ReceptiveFields
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
    receptive_fields: ReceptiveFields = ReceptiveFields.CELL,
) -> F32:
    """Correlate the ON pathway along both axes (T4; paper, equation 9).

    Args:
        on: ON surface now, (rows, columns) float32.
        on_delayed: delayed ON surface, (rows, columns) float32.
        offsets: i, the distances between the two points of a pair, which are summed over [cells].
        pair_location: cell to which a pair belongs.
        receptive_fields: size of the two points of a pair.

    Returns:
        (4, rows, columns) float32, planes right, left, up, down. If the midpoint of a pair lies
        between two cells, as with an odd distance, each cell takes half.
    """
    at_delayed = pair_location is PairLocation.DELAYED
    maps = np.zeros((4, *on.shape), np.float32)
    for i in offsets:
        points = on, on_delayed
        if receptive_fields is ReceptiveFields.DISTANCE:
            points = receptive_field(on, i), receptive_field(on_delayed, i)
        _add_half_detectors(maps, *points, i, at_delayed)
    return maps


def t5(
    off: F32,
    off_delayed: F32,
    *,
    offsets: Sequence[int],
    pair_location: PairLocation = PairLocation.MIDPOINT,
    receptive_fields: ReceptiveFields = ReceptiveFields.CELL,
) -> F32:
    """Correlate the OFF pathway along both axes (T5; paper, equation 9), as `t4` does for ON."""
    return t4(
        off,
        off_delayed,
        offsets=offsets,
        pair_location=pair_location,
        receptive_fields=receptive_fields,
    )


def receptive_field(surface: F32, width: int) -> F32:
    """Return the surface as points of a receptive field see it; cells outside count as 0.

    Args:
        surface: (rows, columns) float32.
        width: width of the field at half its height [cells]. 1: the surface itself.
    """
    if width == 1:
        return surface
    weights = width - np.abs(np.arange(1 - width, width, dtype=np.float32))
    weights /= weights.sum()
    seen = cv2.sepFilter2D(surface, -1, weights, weights, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(seen, np.float32)


@compiled
def _add_half_detectors(maps: Any, now: Any, delayed: Any, i: int, at_delayed: bool) -> None:
    """Add the products of all pairs at distance i to the direction maps."""
    if at_delayed:
        _add_pairs(maps, now, delayed, i, 0, i, np.float32(1.0))
    elif i % 2 == 0:
        _add_pairs(maps, now, delayed, i, i // 2, i // 2, np.float32(1.0))
    else:
        _add_pairs(maps, now, delayed, i, i // 2, i // 2, np.float32(0.5))
        _add_pairs(maps, now, delayed, i, i // 2 + 1, i // 2 + 1, np.float32(0.5))


@compiled
def _add_pairs(
    maps: Any, now: Any, delayed: Any, i: int, forward_at: int, backward_at: int, weight: Any
) -> None:
    """Add the weighted products of all pairs at distance i to the direction maps.

    `forward_at` is the distance from the first point of a pair to the cell that its rightward or
    downward product belongs to; `backward_at` is that of the leftward or upward product.
    """
    rows, columns = now.shape
    for y in range(rows):
        right, left = maps[RIGHT, y, forward_at:], maps[LEFT, y, backward_at:]
        near_now, near_delayed = now[y], delayed[y]
        far_now, far_delayed = now[y, i:], delayed[y, i:]
        for x in range(columns - i):
            right[x] += weight * (near_delayed[x] * far_now[x])
            left[x] += weight * (far_delayed[x] * near_now[x])
    for y in range(rows - i):
        down, up = maps[DOWN, y + forward_at], maps[UP, y + backward_at]
        near_now, near_delayed = now[y], delayed[y]
        far_now, far_delayed = now[y + i], delayed[y + i]
        for x in range(columns):
            down[x] += weight * (near_delayed[x] * far_now[x])
            up[x] += weight * (far_delayed[x] * near_now[x])
