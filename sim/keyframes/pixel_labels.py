"""What each pixel shows, as a number: a body, the street in its light and shadows, or an edge.

A pixel holds S × S points of the fine grid on which geometry is known exactly. Where a pixel and
its neighbours show but one thing, that thing's light is known already for a whole pixel; only
where edges run are points weighed one by one.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]

EDGE = -(1 << 30)
"""Code of a pixel that shows more than one thing."""


@compiled
def pixel_codes(label: I32, size: int) -> I32:
    """(height, width) the body that each pixel shows, -1 for none, `EDGE` for several things."""
    code = np.empty((label.shape[0] // size, label.shape[1] // size), np.int32)
    for row in range(code.shape[0]):
        for column in range(code.shape[1]):
            first = label[row * size, column * size]
            for i in range(row * size, (row + 1) * size):
                for j in range(column * size, (column + 1) * size):
                    if label[i, j] != first:
                        first = EDGE
            code[row, column] = first
    return code


@compiled
def mark_edges(code: I32, lux: F32) -> Bools:
    """Which pixels are to be weighed point by point: they, or neighbours, show several things."""
    height, width = code.shape
    mixed = np.empty(code.shape, np.bool_)  # a pixel and those left and right of it
    for row in range(height):
        for column in range(width):
            left, right = max(column - 1, 0), min(column + 1, width - 1)
            what, dark = code[row, column], lux[row, column] + lux[row, left] + lux[row, right]
            alike = code[row, left] == what and code[row, right] == what and what != EDGE
            mixed[row, column] = not alike or dark > 0.0
    marked = np.empty(code.shape, np.bool_)
    for row in range(height):
        above, below = max(row - 1, 0), min(row + 1, height - 1)
        for column in range(width):
            what = code[row, column]
            marked[row, column] = (
                mixed[row, column]
                or mixed[above, column]
                or mixed[below, column]
                or code[above, column] != what
                or code[below, column] != what
            )
    return marked


@compiled
def with_neighbours(marked: Bools) -> Bools:
    """Which pixels are marked, or have a neighbour that is."""
    height, width = marked.shape
    grown = np.zeros(marked.shape, np.bool_)
    for row in range(height):
        for column in range(width):
            if marked[row, column]:
                for i in range(max(row - 1, 0), min(row + 2, height)):
                    for j in range(max(column - 1, 0), min(column + 2, width)):
                        grown[i, j] = True
    return grown
