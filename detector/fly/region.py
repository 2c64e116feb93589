"""The region of interest: the cells that belong to the object at the view centre."""

from __future__ import annotations

import math

import cv2
import numpy as np
import numpy.typing as npt

_GROWN, _EIGHT_NEIGHBOURS = 2, 8
"""Value of the cells that a region has grown over, and how it grows."""


def search_square(
    shape: tuple[int, int], centre: tuple[float, float], *, reach: float
) -> tuple[slice, slice]:
    """Return the rows and columns of cells whose centres lie in the square around the view centre.

    Args:
        shape: rows and columns of the grid.
        centre: view centre, (x, y), on the grid [cells].
        reach: half side of the square [cells]; below 0.5 the square may contain no cell.
    """
    rows, columns = shape
    left, right = max(0, math.ceil(centre[0] - reach)), min(columns, int(centre[0] + reach) + 1)
    top, bottom = max(0, math.ceil(centre[1] - reach)), min(rows, int(centre[1] + reach) + 1)
    return slice(top, bottom), slice(left, right)


def region_of_interest(
    activity: npt.NDArray[np.float32], centre: tuple[float, float], *, reach: float, share: float
) -> npt.NDArray[np.bool_]:
    """Grow a connected region from the view centre inside the search square (paper, equation 16).

    The region starts at the active cell nearest to the view centre and grows over active cells
    through their eight neighbours.

    Args:
        activity: activity of each cell, (rows, columns) float32.
        centre: view centre, (x, y) [cells].
        reach: R, half side of the search square [cells].
        share: activity above which a cell is active, relative to the largest in the square, in
            (0, 1].

    Returns:
        Ω, (rows, columns) bool; empty if no cell in the square is active.
    """
    rows, columns = search_square(activity.shape, centre, reach=reach)
    square = activity[rows, columns]
    region = np.zeros(activity.shape, np.bool_)
    if square.max(initial=0.0) <= 0.0:
        return region
    active = square >= share * square.max()
    y, x = np.divmod(np.flatnonzero(active), active.shape[1])
    nearest = np.argmin((x + columns.start - centre[0]) ** 2 + (y + rows.start - centre[1]) ** 2)
    grown = active.astype(np.uint8)
    cv2.floodFill(grown, None, (int(x[nearest]), int(y[nearest])), _GROWN, flags=_EIGHT_NEIGHBOURS)
    region[rows, columns] = grown == _GROWN
    return region
