"""Label of what each pixel shows: a body, the background with its shadows, or an edge.

A pixel holds S × S sub-pixels at which geometry is known exactly. If a pixel and its neighbours
show only one thing, the luminance of that thing is already known for a whole pixel. Only near edges
are sub-pixels weighted one by one.

Kernels write only a rectangle of the image's buffers. Indices are converted to unsigned integers,
because numba then leaves out its test for negative indices.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.rectangles import Rectangle

I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]

EDGE = -(1 << 30)
"""Label of a pixel that shows more than one thing."""


@compiled
def label_pixels(label: I32, supersample: int, rectangle: Rectangle, pixel_label: I32) -> None:
    """Set the label of each pixel of a rectangle from those of its sub-pixels.

    Args:
        label: (rows, columns) int32, label of each sub-pixel: a part, or -1 for the background.
        supersample: sub-pixels per pixel and axis.
        rectangle: x0, y0, x1, y1 [px].
        pixel_label: (height, width) int32; set to the label that all sub-pixels of a pixel share,
            else to `EDGE`.
    """
    x0, y0, x1, y1 = rectangle
    start, end = x0 * supersample, x1 * supersample
    differing = np.empty(end, np.int32)
    for row in range(y0, y1):
        top = np.uintp(row * supersample)
        differing[start:end] = 0
        for i in range(row * supersample + 1, (row + 1) * supersample):
            for j in range(start, end):
                differing[np.uintp(j)] |= label[np.uintp(i), np.uintp(j)] ^ label[top, np.uintp(j)]
        for column in range(x0, x1):
            first, mixed = label[top, np.uintp(column * supersample)], np.int32(0)
            for j in range(column * supersample, (column + 1) * supersample):
                mixed |= differing[np.uintp(j)] | (label[top, np.uintp(j)] ^ first)
            pixel_label[np.uintp(row), np.uintp(column)] = EDGE if mixed else first


@compiled
def mark_edges(
    pixel_label: I32, in_beam: Bools, rectangle: Rectangle, marked: Bools, scratch: Bools
) -> None:
    """Mark the pixels of a rectangle whose sub-pixels must be weighted one by one.

    These are the pixels that, together with their neighbours, show more than one thing or lie in a
    beam.

    Args:
        pixel_label: (height, width) labels of the pixels.
        in_beam: (height, width) bool, pixels that a beam lights.
        rectangle: x0, y0, x1, y1 [px].
        marked: (height, width) bool, set.
        scratch: (height, width) bool, overwritten.
    """
    x0, y0, x1, y1 = rectangle
    for row in range(y0, y1):  # first: a pixel with its left and right neighbours
        i = np.uintp(row)
        for column in range(x0, x1):
            at = np.uintp(column)
            left, right = np.uintp(max(column - 1, x0)), np.uintp(min(column + 1, x1 - 1))
            own = pixel_label[i, at]
            alike = (pixel_label[i, left] == own) & (pixel_label[i, right] == own)
            lit = in_beam[i, left] | in_beam[i, at] | in_beam[i, right]
            scratch[i, at] = (not alike) | (own == EDGE) | lit
    for row in range(y0, y1):
        i, above, below = np.uintp(row), np.uintp(max(row - 1, y0)), np.uintp(min(row + 1, y1 - 1))
        for column in range(x0, x1):
            at = np.uintp(column)
            own = pixel_label[i, at]
            marked[i, at] = (
                scratch[i, at]
                | scratch[above, at]
                | scratch[below, at]
                | (pixel_label[above, at] != own)
                | (pixel_label[below, at] != own)
            )


@compiled
def dilate(marked: Bools, rectangle: Rectangle, dilated: Bools) -> None:
    """Mark also the eight neighbours of each marked pixel, within a rectangle.

    Args:
        marked: (height, width) bool.
        rectangle: x0, y0, x1, y1 [px].
        dilated: (height, width) bool, set.
    """
    x0, y0, x1, y1 = rectangle
    dilated[y0:y1, x0:x1] = False
    for row in range(y0, y1):
        for column in range(x0, x1):
            if marked[np.uintp(row), np.uintp(column)]:
                for i in range(max(row - 1, y0), min(row + 2, y1)):
                    for j in range(max(column - 1, x0), min(column + 2, x1)):
                        dilated[np.uintp(i), np.uintp(j)] = True
