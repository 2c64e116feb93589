"""The region of interest: what belongs to the thing that the fly looks at."""

from __future__ import annotations

import math

import cv2
import numpy as np
import numpy.typing as npt


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
    rows, columns = activity.shape
    left, right = max(0, math.ceil(centre[0] - reach)), min(columns, int(centre[0] + reach) + 1)
    top, bottom = max(0, math.ceil(centre[1] - reach)), min(rows, int(centre[1] + reach) + 1)
    square = activity[top:bottom, left:right]
    mask = np.zeros((rows, columns), np.bool_)
    if square.max() <= 0.0:
        return mask
    active = square >= share * square.max()
    y, x = np.nonzero(active)
    nearest = np.argmin((x + left - centre[0]) ** 2 + (y + top - centre[1]) ** 2)
    _, labels = cv2.connectedComponents(active.astype(np.uint8), connectivity=8)
    mask[top:bottom, left:right] = labels == labels[y[nearest], x[nearest]]
    return mask
