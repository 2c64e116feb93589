"""Which pixels show one thing, and which are edges."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.keyframes.pixel_labels import EDGE, mark_edges, pixel_codes, with_neighbours
from sim.shadows.moving_light import MOST_SHADOWS

I32 = npt.NDArray[np.int32]


def test_a_pixel_of_one_thing_has_its_code_and_one_of_several_is_an_edge() -> None:
    label = np.full((4, 6), -1, np.int32)
    label[:2, 2:4], label[2:, 3:] = 7, 5
    assert pixel_codes(label, 2).tolist() == [[-1, 7, -1], [-1, EDGE, 5]]


def test_an_edge_and_all_its_neighbours_are_marked() -> None:
    code = np.full((7, 8), -1, np.int32)
    code[3, 4] = EDGE
    expected = np.zeros(code.shape, bool)
    expected[2:5, 3:6] = True
    assert np.array_equal(mark_edges(code, np.zeros(code.shape, np.float32)), expected)


@pytest.mark.parametrize("axis", [0, 1])
def test_two_things_side_by_side_mark_the_pixels_where_they_meet(axis: int) -> None:
    code = np.full((6, 6), -1, np.int32)
    code[3:] = 2
    expected = np.zeros(code.shape, bool)
    expected[2:4] = True
    if axis == 1:
        code, expected = code.T.copy(), expected.T
    assert np.array_equal(mark_edges(code, np.zeros(code.shape, np.float32)), expected)


def test_what_beams_light_is_marked() -> None:
    lux = np.zeros((5, 9), np.float32)
    lux[2, 4] = 3.0
    marked = mark_edges(np.full(lux.shape, -1, np.int32), lux)
    assert np.array_equal(marked, with_neighbours(lux > 0))


def test_neighbours_end_with_the_image() -> None:
    marked = np.zeros((3, 4), bool)
    marked[0, 3] = True
    expected = np.zeros((3, 4), bool)
    expected[:2, 2:] = True
    assert np.array_equal(with_neighbours(marked), expected)


def test_no_state_of_all_shadows_is_an_edges_code() -> None:
    assert -1 - ((1 << MOST_SHADOWS) - 1) > EDGE
