"""Labels of pixels that show one thing or an edge, and the marks around edges."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.compositing.pixel_labels import EDGE, dilate, label_pixels, mark_edges
from sim.shadows.shadows_and_beams import MAX_SHADOWS

I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]


def whole(image: npt.NDArray[np.generic]) -> tuple[int, int, int, int]:
    return 0, 0, image.shape[1], image.shape[0]


def marked(label: I32, in_beam: Bools | None = None) -> Bools:
    found, lit = np.empty(label.shape, bool), np.zeros(label.shape, bool)
    rectangle = whole(label)
    mark_edges(label, lit if in_beam is None else in_beam, rectangle, found, np.empty_like(found))
    return found


def dilated(image: Bools) -> Bools:
    found = np.empty_like(image)
    dilate(image, whole(image), found)
    return found


def test_a_pixel_has_the_label_that_its_subpixels_share_and_is_an_edge_otherwise() -> None:
    label = np.full((4, 6), -1, np.int32)
    label[:2, 2:4], label[2:, 3:] = 7, 5
    found = np.zeros((2, 3), np.int32)
    label_pixels(label, 2, whole(found), found)
    assert found.tolist() == [[-1, 7, -1], [-1, EDGE, 5]]


def test_only_the_rectangle_is_written() -> None:
    found = np.full((2, 3), 9, np.int32)
    label_pixels(np.full((4, 6), -1, np.int32), 2, (1, 0, 2, 2), found)
    assert found.tolist() == [[9, -1, 9], [9, -1, 9]]


def test_an_edge_and_all_its_neighbours_are_marked() -> None:
    label = np.full((7, 8), -1, np.int32)
    label[3, 4] = EDGE
    expected = np.zeros(label.shape, bool)
    expected[2:5, 3:6] = True
    assert np.array_equal(marked(label), expected)


@pytest.mark.parametrize("axis", [0, 1])
def test_pixels_where_two_labels_meet_are_marked(axis: int) -> None:
    label = np.full((6, 6), -1, np.int32)
    label[3:] = 2
    expected = np.zeros(label.shape, bool)
    expected[2:4] = True
    if axis == 1:
        label, expected = label.T.copy(), expected.T.copy()
    assert np.array_equal(marked(label), expected)


def test_pixels_in_and_beside_beams_are_marked() -> None:
    in_beam = np.zeros((5, 9), bool)
    in_beam[2, 4] = True
    assert np.array_equal(marked(np.full((5, 9), -1, np.int32), in_beam), dilated(in_beam))


def test_dilation_stops_at_the_border() -> None:
    corner, expected = np.zeros((3, 4), bool), np.zeros((3, 4), bool)
    corner[0, 3] = expected[:2, 2:] = True
    assert np.array_equal(dilated(corner), expected)


def test_no_combination_of_shadows_has_the_label_of_an_edge() -> None:
    assert -1 - ((1 << MAX_SHADOWS) - 1) > EDGE
