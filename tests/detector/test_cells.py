"""Cells that are centred on the sensor."""

from itertools import product

import numpy as np
import pytest

from detector.cells import OUTSIDE, centred_cells, covering_cells


@pytest.mark.parametrize(("size_px", "cell_px"), list(product(range(5, 14), (1, 2, 3, 4))))
def test_both_ends_are_alike(size_px: int, cell_px: int) -> None:
    for cells in range(1, size_px // cell_px + 2):
        at = centred_cells(size_px, cell_px, cells)
        back = np.where(at == OUTSIDE, OUTSIDE, cells - 1 - at)[::-1]
        np.testing.assert_array_equal(at, back)
        assert (np.diff(at[at != OUTSIDE]) >= 0).all()


@pytest.mark.parametrize(("size_px", "cell_px"), list(product(range(5, 14), (1, 2, 3, 4))))
def test_covering_cells_leave_out_no_pixel(size_px: int, cell_px: int) -> None:
    cells = covering_cells(size_px, cell_px)
    assert (centred_cells(size_px, cell_px, cells) != OUTSIDE).all()
    assert cells <= -(-size_px // cell_px) + 1
