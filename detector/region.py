"""The region of interest: what belongs to the thing that the fly looks at."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit


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
    mask: npt.NDArray[np.bool_] = _grow(activity, centre[0], centre[1], reach, share)
    return mask


@njit(cache=True)
def _grow(activity: Any, centre_x: float, centre_y: float, reach: float, share: float) -> Any:
    rows, columns = activity.shape
    mask = np.zeros((rows, columns), np.bool_)
    left, right = max(0, int(np.ceil(centre_x - reach))), min(columns, int(centre_x + reach) + 1)
    top, bottom = max(0, int(np.ceil(centre_y - reach))), min(rows, int(centre_y + reach) + 1)
    strongest = activity[top:bottom, left:right].max()
    if strongest <= 0.0:
        return mask
    active = activity >= share * strongest
    nearest, seed_x, seed_y = np.inf, 0, 0
    for y in range(top, bottom):
        for x in range(left, right):
            distance = (x - centre_x) ** 2 + (y - centre_y) ** 2
            if active[y, x] and distance < nearest:
                nearest, seed_x, seed_y = distance, x, y
    stack = [(seed_x, seed_y)]
    mask[seed_y, seed_x] = True
    while stack:
        x, y = stack.pop()
        for j in range(max(y - 1, top), min(y + 2, bottom)):
            for i in range(max(x - 1, left), min(x + 2, right)):
                if active[j, i] and not mask[j, i]:
                    mask[j, i] = True
                    stack.append((i, j))
    return mask
