"""Points of a rendered image that should show a part, and show nothing.

Filament and `sim.raster.scan_conversion` round corners to different grids. Along thin parts they
disagree at a few points in ten thousand. Where another moving object is behind such a point, the
renderer shows that object, and the point is not found.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]

REACH = 6
"""Distance to which a hole's surroundings are searched [grid points] (assumed: a pixel)."""


@compiled
def fill_holes(image: F32, label: I32) -> None:
    """Give each point that shows nothing, but has a label, the mean of its surroundings.

    These are the nearest rendered points of the same part; if there are none within `REACH`, the
    nearest rendered points of anything. Without them the hole remains.

    Args:
        image: (layers, rows, columns) luminance, 0 where nothing was rendered; changed.
        label: (rows, columns) number of the part, negative for none.
    """
    rows, columns = label.shape
    rendered = np.zeros(label.shape, np.bool_)
    for layer in image:
        rendered |= layer != 0
    for i in range(rows):
        for j in range(columns):
            if label[i, j] < 0 or rendered[i, j]:
                continue
            if not _fill(image, label, rendered, i, j, True):
                _fill(image, label, rendered, i, j, False)


@compiled
def _fill(image: F32, label: I32, rendered: Bools, i: int, j: int, same_part: bool) -> bool:
    """Fill one hole from the smallest square around it that shows something; False if none does."""
    rows, columns = label.shape
    for reach in range(1, REACH + 1):
        total, count = np.zeros(len(image), np.float32), 0
        for row in range(max(i - reach, 0), min(i + reach + 1, rows)):
            for column in range(max(j - reach, 0), min(j + reach + 1, columns)):
                if rendered[row, column] and (not same_part or label[row, column] == label[i, j]):
                    total += image[:, row, column]
                    count += 1
        if count:
            image[:, i, j] = total / np.float32(count)
            return True
    return False
