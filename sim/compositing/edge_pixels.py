"""Pixels at edges: the weighted mean of the sub-pixels in their aperture.

A run of neighbouring pixels is summed along the columns of sub-pixels first, which they share.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined
from sim.compositing.canvas import Canvas
from sim.compositing.surface_lookup import Surfaces, surface_luminance
from sim.geometry.rectangles import Rectangle
from sim.raster.aperture import aperture_weights

F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]

NO_PART = np.int32(2**31 - 1)
"""A number above that of every part."""


class Aperture(NamedTuple):
    """Sub-pixels in the aperture of a pixel: S × S of its own, and as many of each neighbour.

    Attributes:
        weights: (3 S,) float64 weights along an axis, with a sum of 1.
        order: (9 S², 2) int64 rows and columns of the sub-pixels, the nearest to the pixel's centre
            first.
    """

    weights: F64
    order: I64


def aperture(supersample: int, blur_px: float) -> Aperture:
    """Return the aperture of a pixel.

    Args:
        supersample: sub-pixels per pixel and axis, S.
        blur_px: standard deviation of the lens's point spread [px].
    """
    count = 3 * supersample
    rows, columns = np.divmod(np.arange(count * count), count)
    off = (2 * rows + 1 - count) ** 2 + (2 * columns + 1 - count) ** 2
    nearest = np.argsort(off, kind="stable")
    order = np.stack([rows[nearest], columns[nearest]], axis=1)
    weights = aperture_weights(supersample, blur_px).astype(np.float64)
    return Aperture(weights / weights.sum(), order)


@compiled
def blend_edge_pixels(
    canvas: Canvas, surfaces: Surfaces, seen: Aperture, rectangle: Rectangle
) -> None:
    """Blend the marked pixels from their sub-pixels, weighted with the aperture.

    The luminance of a part is looked up once for a pixel, at the part's sub-pixel nearest to the
    pixel centre.
    """
    x0, y0, x1, y1 = rectangle
    weights = seen.weights
    size = len(weights) // 3
    columns = np.empty((2, x1 * size)), np.empty((2, x1 * size), np.int32)
    offsets = seen.order[:, 0] * canvas.label.shape[1] + seen.order[:, 1]
    parts, coverage = np.empty((9 * size * size, 3), np.int64), np.empty(9 * size * size)
    for row in range(y0, y1):
        column, end = x0, x0
        while column < x1:
            if not canvas.marked[np.uintp(row), np.uintp(column)]:
                column += 1
                continue
            if column >= end:
                end = column + 1
                while end < x1 and canvas.marked[np.uintp(row), np.uintp(end)]:
                    end += 1
                _sum_columns(canvas, weights, row, column, end, rectangle, *columns)
            value, open_share, total, lowest, highest = _sum_rows(
                weights, row, column, rectangle, *columns
            )
            if highest >= 0 and lowest == highest:
                i, j = _nearest(canvas.label, seen, offsets, highest, row, column, rectangle)
                light = _part_luminance(canvas, surfaces, size, highest, row, column, i, j)
                value += (total - open_share) * light
            elif highest >= 0:
                found = _coverages(canvas.label, weights, row, column, rectangle, parts, coverage)
                for k in range(found):
                    part, i, j = parts[k]
                    light = _part_luminance(canvas, surfaces, size, part, row, column, i, j)
                    value += coverage[k] * light
            canvas.image[np.uintp(row), np.uintp(column)] = value / total
            column += 1


@inlined
def _sum_columns(
    canvas: Canvas,
    weights: F64,
    row: int,
    start: int,
    end: int,
    rectangle: Rectangle,
    sums: F64,
    parts: I32,
) -> None:
    """Weight the sub-pixels in each column of sub-pixels around a run of pixels.

    Args:
        canvas: the canvas.
        weights: weights of the aperture along an axis.
        row: row of the pixels.
        start: first pixel.
        end: pixel after the last.
        rectangle: x0, y0, x1, y1 [px]; what lies outside does not count.
        sums: (2, columns) set to weight × luminance of the background that is not hidden, and to
            its weight.
        parts: (2, columns) set to the lowest and the highest part.
    """
    x0, y0, x1, y1 = rectangle
    size = len(weights) // 3
    first, last = max(start - 1, x0) * size, min(end + 1, x1) * size
    for j in range(first, last):
        u = np.uintp(j)
        sums[0, u], sums[1, u] = 0.0, 0.0
        parts[0, u], parts[1, u] = NO_PART, -1
    shift = (row - 1) * size
    for i in range(max(shift, y0 * size), min(shift + 3 * size, y1 * size)):
        v, weight = np.uintp(i), weights[np.uintp(i - shift)]
        for j in range(first, last):
            u = np.uintp(j)
            part = canvas.label[v, u]
            seen = weight if part < 0 else 0.0
            sums[0, u] += seen * canvas.background[v, u]
            sums[1, u] += seen
            parts[0, u] = min(parts[0, u], NO_PART if part < 0 else part)
            parts[1, u] = max(parts[1, u], part)


@inlined
def _sum_rows(
    weights: F64, row: int, column: int, rectangle: Rectangle, sums: F64, parts: I32
) -> tuple[float, float, float, int, int]:
    """Weight the columns of sub-pixels of a pixel's aperture.

    Args:
        weights: weights of the aperture along an axis.
        row: row of the pixel.
        column: column of the pixel.
        rectangle: x0, y0, x1, y1 [px]; what lies outside does not count.
        sums: from `_sum_columns`.
        parts: from `_sum_columns`.

    Returns:
        Weight × luminance of the background, weight of the background, weight of everything, and
        the lowest and the highest part, which is negative if there is none.
    """
    x0, y0, x1, y1 = rectangle
    size = len(weights) // 3
    value, seen, across = 0.0, 0.0, 0.0
    lowest, highest = NO_PART, np.int32(-1)
    shift = (column - 1) * size
    for j in range(max(shift, x0 * size), min(shift + 3 * size, x1 * size)):
        u, weight = np.uintp(j), weights[np.uintp(j - shift)]
        value += weight * sums[0, u]
        seen += weight * sums[1, u]
        across += weight
        lowest, highest = min(lowest, parts[0, u]), max(highest, parts[1, u])
    shift, down = (row - 1) * size, 0.0
    for i in range(max(shift, y0 * size), min(shift + 3 * size, y1 * size)):
        down += weights[np.uintp(i - shift)]
    return value, seen, across * down, int(lowest), int(highest)


@inlined
def _coverages(
    label: I32,
    weights: F64,
    row: int,
    column: int,
    rectangle: Rectangle,
    parts: I64,
    coverage: F64,
) -> int:
    """Find the parts in a pixel's aperture and their weights, and return their number.

    Args:
        label: labels of the sub-pixels.
        weights: weights of the aperture along an axis.
        row: row of the pixel.
        column: column of the pixel.
        rectangle: x0, y0, x1, y1 [px]; what lies outside does not count.
        parts: (n, 3) set to the number of each part, and row and column of its sub-pixel that is
            nearest to the pixel centre.
        coverage: (n,) set to their weights.
    """
    x0, y0, x1, y1 = rectangle
    size, found = len(weights) // 3, 0
    above, first = (row - 1) * size, (column - 1) * size
    left, right = max(first, x0 * size), min(first + 3 * size, x1 * size)
    middle = first + (3 * size - 1) // 2
    for i in range(max(above, y0 * size), min(above + 3 * size, y1 * size)):
        down, start = weights[np.uintp(i - above)], left
        while start < right:
            part, stop, share = label[np.uintp(i), np.uintp(start)], start, 0.0
            while stop < right and label[np.uintp(i), np.uintp(stop)] == part:
                share += weights[np.uintp(stop - first)]
                stop += 1
            if part >= 0:
                k = 0
                while k < found and parts[k, 0] != part:
                    k += 1
                if k == found:
                    parts[k, 0], parts[k, 1], parts[k, 2] = part, above - 3 * size, first
                    coverage[k] = 0.0
                    found += 1
                coverage[k] += down * share
                nearest = min(max(middle, start), stop - 1)
                if _off_centre(i - above, nearest - first, size) < _off_centre(
                    parts[k, 1] - above, parts[k, 2] - first, size
                ):
                    parts[k, 1], parts[k, 2] = i, nearest
            start = stop
    return found


@inlined
def _off_centre(row: int, column: int, size: int) -> int:
    """Return four times the squared distance of a sub-pixel from the centre of an aperture."""
    down, right = 2 * row + 1 - 3 * size, 2 * column + 1 - 3 * size
    return down * down + right * right


@inlined
def _nearest(
    label: I32,
    seen: Aperture,
    offsets: I64,
    part: int,
    row: int,
    column: int,
    rectangle: Rectangle,
) -> tuple[int, int]:
    """Return row and column of the sub-pixel of a part that is nearest to a pixel's centre.

    Args:
        label: labels of the sub-pixels.
        seen: aperture of a pixel.
        offsets: distance of each sub-pixel of `seen.order` from the first of the aperture in the
            flattened labels.
        part: number of a part that is in the aperture.
        row: row of the pixel.
        column: column of the pixel.
        rectangle: x0, y0, x1, y1 [px]; what lies outside does not count.
    """
    x0, y0, x1, y1 = rectangle
    size, flat = len(seen.weights) // 3, label.reshape(-1)
    above, first, k = (row - 1) * size, (column - 1) * size, 0
    if x0 < column < x1 - 1 and y0 < row < y1 - 1:
        start = above * label.shape[1] + first
        while flat[np.uintp(start + offsets[np.uintp(k)])] != part:
            k += 1
    else:
        i, j = above + seen.order[0, 0], first + seen.order[0, 1]
        while not (
            y0 * size <= i < y1 * size and x0 * size <= j < x1 * size and label[i, j] == part
        ):
            k += 1
            i, j = above + seen.order[k, 0], first + seen.order[k, 1]
    return above + seen.order[np.uintp(k), 0], first + seen.order[np.uintp(k), 1]


@inlined
def _part_luminance(
    canvas: Canvas,
    surfaces: Surfaces,
    size: int,
    part: int,
    row: int,
    column: int,
    i: int,
    j: int,
) -> float:
    """Return the luminance of a part around a pixel's centre, looked up at its sub-pixel i, j."""
    nearness = canvas.nearness[np.uintp(i), np.uintp(j)]
    right, down = j + 0.5 - (column + 0.5) * size, i + 0.5 - (row + 0.5) * size
    return surface_luminance(
        surfaces, part, (j + 0.5) / size, (i + 0.5) / size, nearness, right, down
    )
