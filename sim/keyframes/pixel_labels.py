"""Label of what each pixel shows: a body, the background with its shadows, or an edge.

A pixel holds S × S sub-pixels at which geometry is known exactly. If a pixel and its neighbours
show only one thing, the luminance of that thing is already known for a whole pixel. Only near edges
are sub-pixels weighted one by one.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]

EDGE = -(1 << 30)
"""Label of a pixel that shows more than one thing."""


@compiled
def pixel_labels(label: I32, supersample: int) -> I32:
    """Return the label of each pixel from those of its sub-pixels.

    Args:
        label: (rows, columns) int32, label of each sub-pixel: body, or -1 for the background.
        supersample: sub-pixels per pixel and axis.

    Returns:
        (height, width) int32: the label that all sub-pixels share, else `EDGE`.
    """
    height, width = label.shape[0] // supersample, label.shape[1] // supersample
    pixel_label = np.empty((height, width), np.int32)
    for row in range(height):
        for column in range(width):
            first = label[row * supersample, column * supersample]
            for i in range(row * supersample, (row + 1) * supersample):
                for j in range(column * supersample, (column + 1) * supersample):
                    if label[i, j] != first:
                        first = EDGE
            pixel_label[row, column] = first
    return pixel_label


@compiled
def mark_edges(pixel_label: I32, lux: F32) -> Bools:
    """Mark the pixels whose sub-pixels must be weighted one by one.

    These are the pixels that, together with their neighbours, show more than one thing or lie in a
    beam.

    Args:
        pixel_label: (height, width) labels of the pixels.
        lux: (height, width) illuminance from beams [lux].
    """
    height, width = pixel_label.shape
    mixed = np.empty(pixel_label.shape, np.bool_)  # of a pixel and its left and right neighbours
    for row in range(height):
        for column in range(width):
            left, right = max(column - 1, 0), min(column + 1, width - 1)
            own, beams = (
                pixel_label[row, column],
                lux[row, column] + lux[row, left] + lux[row, right],
            )
            alike = pixel_label[row, left] == own and pixel_label[row, right] == own and own != EDGE
            mixed[row, column] = not alike or beams > 0.0
    marked = np.empty(pixel_label.shape, np.bool_)
    for row in range(height):
        above, below = max(row - 1, 0), min(row + 1, height - 1)
        for column in range(width):
            own = pixel_label[row, column]
            marked[row, column] = (
                mixed[row, column]
                or mixed[above, column]
                or mixed[below, column]
                or pixel_label[above, column] != own
                or pixel_label[below, column] != own
            )
    return marked


@compiled
def dilate(marked: Bools) -> Bools:
    """Mark also the eight neighbours of each marked pixel."""
    height, width = marked.shape
    dilated = np.zeros(marked.shape, np.bool_)
    for row in range(height):
        for column in range(width):
            if marked[row, column]:
                for i in range(max(row - 1, 0), min(row + 2, height)):
                    for j in range(max(column - 1, 0), min(column + 2, width)):
                        dilated[i, j] = True
    return dilated
