"""The maps behind an estimate of the fly."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

F32 = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class FlyMaps:
    """The maps behind the last estimate, for display; each estimate makes new ones.

    Attributes:
        on: ON surface, (rows, columns) float32, one value per cell, dimensionless.
        off: OFF surface, (rows, columns) float32.
        motion: T4 + T5, (4, rows, columns) float32, planes right, left, up, down.
        saliency: smoothed H_on + H_off, (rows, columns) float32.
        attended: region of interest, (rows, columns) bool.
        cell_px: side of a cell [px].
        origin_px: corner of the first cell, (x, y) on the sensor, not positive [px].
    """

    on: F32
    off: F32
    motion: F32
    saliency: F32
    attended: npt.NDArray[np.bool_]
    cell_px: int
    origin_px: tuple[int, int] = (0, 0)

    @classmethod
    def blank(
        cls, grid: tuple[int, int], *, cell_px: int, origin_px: tuple[int, int] = (0, 0)
    ) -> FlyMaps:
        """Return maps without activity, for a grid of (rows, columns)."""
        blank = np.zeros(grid, np.float32)
        return cls(
            on=blank,
            off=blank,
            motion=np.zeros((4, *grid), np.float32),
            saliency=blank,
            attended=np.zeros(grid, np.bool_),
            cell_px=cell_px,
            origin_px=origin_px,
        )

    def bounding_box_px(self, *, width: int, height: int) -> tuple[int, int, int, int] | None:
        """Return the bounding box of the region of interest; None if the region is empty.

        Args:
            width: sensor columns [px].
            height: sensor rows [px].

        Returns:
            (x0, y0, x1, y1), half-open, clipped to the sensor [px].
        """
        column, row, columns, rows = cv2.boundingRect(self.attended.view(np.uint8))
        if columns == 0:
            return None
        left, top = self.origin_px
        x0, y0 = left + column * self.cell_px, top + row * self.cell_px
        x1, y1 = x0 + columns * self.cell_px, y0 + rows * self.cell_px
        return max(x0, 0), max(y0, 0), min(x1, width), min(y1, height)
