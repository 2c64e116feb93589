"""Cells that are centred on the sensor, so that mirrored streams give mirrored answers."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

OUTSIDE = -1
"""Cell of a pixel that belongs to none."""


def centred_cells(size_px: int, cell_px: int, cells: int) -> npt.NDArray[np.int64]:
    """Return the cell of each pixel along an axis; pixel n from either end has cell n from there.

    If the cells cannot leave equally many pixels free at both ends, an odd number of cells has a
    middle one that is a pixel wider, and an even number leaves out the pixel in the middle.

    Args:
        size_px: number of pixels.
        cell_px: side of a cell [px].
        cells: number of cells; together they may be longer than the axis.

    Returns:
        (size_px,) int64: 0 to cells − 1, or `OUTSIDE`.
    """
    pixels = np.arange(size_px)
    from_left = (pixels - (size_px - cells * cell_px) // 2) // cell_px
    from_right = cells - 1 - from_left[::-1]
    at = np.where(2 * pixels < size_px, from_left, from_right)
    is_middle = 2 * pixels + 1 == size_px
    is_inside = (at >= 0) & (at < cells) & ~(is_middle & (from_left != from_right))
    return np.where(is_inside, at, OUTSIDE)


def covering_cells(size_px: int, cell_px: int) -> int:
    """Return the least number of cells with which `centred_cells` leaves out no pixel."""
    cells = -(-size_px // cell_px)
    is_centred = (cells * cell_px - size_px) % 2 == 0
    if is_centred or (cell_px % 2 == 0 and cells % 2):
        return cells
    return cells + 1
