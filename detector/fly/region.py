"""The region of interest: what belongs to the thing that the fly looks at."""

from __future__ import annotations

import math

import cv2
import numpy as np
import numpy.typing as npt


def search_square(
    shape: tuple[int, int], centre: tuple[float, float], *, reach: float
) -> tuple[slice, slice]:
    """Rows and columns of the cells whose centres lie within reach of the view centre.

    Args:
        shape: rows and columns of the grid.
        centre: view centre, (x, y), on the grid [cells].
        reach: half side of the square [cells]; below 0.5 it may hold no cell.
    """
    rows, columns = shape
    left, right = max(0, math.ceil(centre[0] - reach)), min(columns, int(centre[0] + reach) + 1)
    top, bottom = max(0, math.ceil(centre[1] - reach)), min(rows, int(centre[1] + reach) + 1)
    return slice(top, bottom), slice(left, right)


def region_of_interest(
    activity: npt.NDArray[np.float32], centre: tuple[float, float], *, reach: float, share: float
) -> npt.NDArray[np.bool_]:
    """Connected region grown from the view centre inside the search square (paper, equation 16).

    It starts at the active cell nearest to the centre and takes in its eight neighbours in turn.

    Args:
        activity: what the region may grow on, (rows, columns) float32.
        centre: view centre [cells].
        reach: R, half side of the search square [cells].
        share: of the square's largest activity, what makes a cell active, in (0, 1].

    Returns:
        Ω, (rows, columns) bool; empty where nothing is active within reach.
    """
    rows, columns = search_square(activity.shape, centre, reach=reach)
    square = activity[rows, columns]
    mask = np.zeros(activity.shape, np.bool_)
    if square.max(initial=0.0) <= 0.0:
        return mask
    active = square >= share * square.max()
    y, x = np.nonzero(active)
    nearest = np.argmin((x + columns.start - centre[0]) ** 2 + (y + rows.start - centre[1]) ** 2)
    _, labels = cv2.connectedComponents(active.astype(np.uint8), connectivity=8)
    mask[rows, columns] = labels == labels[y[nearest], x[nearest]]
    return mask
