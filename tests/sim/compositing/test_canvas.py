"""The canvas: moving parts are written over a map of bodies, and wiped off."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.compositing.canvas import blank_canvas, show_bodies, wipe
from sim.raster.scan_conversion import NO_LABEL
from tests.sim.flat_background import flat_background

I32 = npt.NDArray[np.int32]
BODY_OF_PART = np.array([0, 1, 2, 1], np.int32)


def labels(size: int, row: int, column: int, part: int) -> I32:
    """Return labels of 2 × 3 pixels of which one sub-pixel shows a part."""
    label = np.full((2 * size, 3 * size), NO_LABEL, np.int32)
    label[row, column] = part
    return label


@pytest.mark.parametrize(("size", "row", "column"), [(1, 1, 2), (3, 4, 7), (4, 6, 10)])
def test_a_pixel_shows_the_body_at_its_centre_or_just_after_it(
    size: int, row: int, column: int
) -> None:
    body = np.full((2, 3), 7, np.int32)
    show_bodies(labels(size, row, column, 3), BODY_OF_PART, size, (0, 0, 3, 2), body)
    assert body.tolist() == [[7, 7, 7], [7, 7, 1]]
    if size > 1:
        show_bodies(labels(size, row - 1, column, 2), BODY_OF_PART, size, (0, 0, 3, 2), body)
    assert body.tolist() == [[7, 7, 7], [7, 7, 1]]


def test_only_the_rectangle_is_written() -> None:
    body, label = np.full((2, 3), 7, np.int32), np.full((2, 3), 3, np.int32)
    show_bodies(label, BODY_OF_PART, 1, (1, 0, 3, 1), body)
    assert body.tolist() == [[7, 1, 1], [7, 7, 7]]


def test_a_wiped_canvas_is_blank() -> None:
    background = flat_background(4.0, np.array([1.0, 2.0]))
    canvas, blank = (blank_canvas(background) for _ in range(2))
    canvas.label[30:60, 30:90] = 5
    canvas.nearness[30:60, 30:90] = 9.0
    wipe(canvas, background, (10, 10, 30, 20), 3)
    np.testing.assert_array_equal(canvas.label, blank.label)
    np.testing.assert_array_equal(canvas.nearness, blank.nearness)
