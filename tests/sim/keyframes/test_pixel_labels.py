"""Labels of pixels that show one thing or an edge, and the marks around edges."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.keyframes.pixel_labels import EDGE, dilate, mark_edges, pixel_labels
from sim.shadows.shadows_and_beams import MAX_SHADOWS

I32 = npt.NDArray[np.int32]


def test_a_pixel_has_the_label_that_its_subpixels_share_and_is_an_edge_otherwise() -> None:
    label = np.full((4, 6), -1, np.int32)
    label[:2, 2:4], label[2:, 3:] = 7, 5
    assert pixel_labels(label, 2).tolist() == [[-1, 7, -1], [-1, EDGE, 5]]


def test_an_edge_and_all_its_neighbours_are_marked() -> None:
    label = np.full((7, 8), -1, np.int32)
    label[3, 4] = EDGE
    expected = np.zeros(label.shape, bool)
    expected[2:5, 3:6] = True
    assert np.array_equal(mark_edges(label, np.zeros(label.shape, np.float32)), expected)


@pytest.mark.parametrize("axis", [0, 1])
def test_pixels_where_two_labels_meet_are_marked(axis: int) -> None:
    label = np.full((6, 6), -1, np.int32)
    label[3:] = 2
    expected = np.zeros(label.shape, bool)
    expected[2:4] = True
    if axis == 1:
        label, expected = label.T.copy(), expected.T
    assert np.array_equal(mark_edges(label, np.zeros(label.shape, np.float32)), expected)


def test_pixels_in_and_beside_beams_are_marked() -> None:
    lux = np.zeros((5, 9), np.float32)
    lux[2, 4] = 3.0
    marked = mark_edges(np.full(lux.shape, -1, np.int32), lux)
    assert np.array_equal(marked, dilate(lux > 0))


def test_dilation_stops_at_the_border() -> None:
    marked = np.zeros((3, 4), bool)
    marked[0, 3] = True
    expected = np.zeros((3, 4), bool)
    expected[:2, 2:] = True
    assert np.array_equal(dilate(marked), expected)


def test_no_combination_of_shadows_has_the_label_of_an_edge() -> None:
    assert -1 - ((1 << MAX_SHADOWS) - 1) > EDGE
