"""Triangles of a height field, as the renderer renders it."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]


def height_field_triangles(model: mujoco.MjModel, number: int) -> F64:
    """Return the (n, 3, 3) triangles of a height field in its own frame [m].

    Each cell of the grid is a pyramid of four triangles. Walls and a floor close the field.
    """
    half_x, half_y, top, bottom = model.hfield_size[number]
    rows, columns = int(model.hfield_nrow[number]), int(model.hfield_ncol[number])
    heights = model.hfield_data[model.hfield_adr[number] :][: rows * columns]
    grid = np.empty((rows, columns, 3))
    grid[..., 0] = np.linspace(-half_x, half_x, columns)
    grid[..., 1] = np.linspace(-half_y, half_y, rows)[:, None]
    grid[..., 2] = top * heights.reshape(rows, columns)
    corners = np.array([(-1, -1), (-1, 1), (1, 1), (1, -1)]) * (half_x, half_y)
    floor = np.column_stack([corners, np.full(4, -bottom)])
    return np.concatenate([_cells(grid), _walls(grid, -bottom), floor[[[0, 1, 2], [0, 2, 3]]]])


def _cells(grid: F64) -> F64:
    """Return four triangles for each cell, anticlockwise as seen from above."""
    around = [grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]]
    middle = (around[0] + around[2]) / 2
    middle[..., 2] = _middle_heights(*(corner[..., 2] for corner in around))
    faces = [np.stack([around[k], around[(k + 1) % 4], middle], axis=-2) for k in range(4)]
    return np.concatenate(faces).reshape(-1, 3, 3)


def _middle_heights(a: F64, b: F64, c: F64, d: F64) -> F64:
    """Return the height of each cell's middle: that of a level diagonal, else the higher one.

    A cell with one level diagonal thus consists of two flat halves.
    """
    higher = np.maximum((a + c) / 2, (b + d) / 2)
    level = [(a == c) & (b != d), (a != c) & (b == d)]
    return np.asarray(np.select(level, [a, b], higher))


def _walls(grid: F64, floor: float) -> F64:
    """Return the walls from the edge of the grid down to the floor, facing outwards."""
    edges = (grid[0], grid[:, -1], grid[-1, ::-1], grid[::-1, 0])
    start = np.concatenate([edge[:-1] for edge in edges])
    end = np.concatenate([edge[1:] for edge in edges])
    below_start, below_end = start.copy(), end.copy()
    below_start[:, 2] = below_end[:, 2] = floor
    lower = np.stack([below_start, below_end, end], axis=1)
    return np.concatenate([lower, np.stack([below_start, end, start], axis=1)])
