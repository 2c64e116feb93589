"""Rectangles hold the points they are made for, and merge without overlap."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rectangles import (
    MARGIN_PX,
    NOWHERE,
    Rectangle,
    enclosing_rectangle,
    image_rectangle,
    joint_rectangles,
    merge_overlapping,
    rectangle_around,
    rectangle_of_points,
)

F64 = npt.NDArray[np.float64]

LENS = Intrinsics()
POSE = Pose(np.array([0.0, -7.0, 1.2]))


def test_a_rectangle_has_whole_pixels_and_a_margin_inside_the_image() -> None:
    m = MARGIN_PX
    span = rectangle_around(np.array([10.2, 20.0]), np.array([30.0, 40.7]), LENS)
    assert span == (10 - m, 20 - m, 30 + m, 41 + m)
    assert rectangle_around(
        np.array([-9.0, -9.0]), np.array([999.0, 999.0]), LENS
    ) == image_rectangle(LENS)
    assert rectangle_around(np.array([346.0 + m, 0.0]), np.array([400.0, 9.0]), LENS) is None


def test_points_on_both_sides_of_the_camera_fill_the_image() -> None:
    before, behind = np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, -9.0, 1.0]])
    assert rectangle_of_points(np.concatenate([before, behind]), POSE, LENS) == image_rectangle(
        LENS
    )
    assert rectangle_of_points(behind, POSE, LENS) is None


def test_joint_rectangles_hold_the_boxes_of_their_group() -> None:
    m, inf = MARGIN_PX, np.inf
    bounds = np.array(
        [[10.2, 20.0, 12.0, 21.0], [400.0, 5.0, 500.0, 9.0], [30.0, 5.5, 40.5, 9.0], [inf] * 4]
    )
    bounds[3, 2:] = -inf
    group = np.array([0, 1, 0, 2])
    found = joint_rectangles(bounds, group, 4, LENS.width, LENS.height).tolist()
    assert found == [[10 - m, 5 - m, 41 + m, 21 + m], *[list(NOWHERE)] * 3]
    alone = joint_rectangles(bounds, np.array([-1, -1, 0, -1]), 1, LENS.width, LENS.height)
    assert alone.tolist() == [[30 - m, 5 - m, 41 + m, 9 + m]]


def random_rectangles(count: int, seed: int) -> list[Rectangle]:
    random = np.random.default_rng(seed)
    low = random.integers(0, 90, (count, 2))
    high = low + random.integers(1, 12, (count, 2))
    return [(int(a), int(b), int(c), int(d)) for (a, b), (c, d) in zip(low, high, strict=True)]


def painted(rectangles: list[Rectangle]) -> npt.NDArray[np.int64]:
    count = np.zeros((102, 102), np.int64)
    for x0, y0, x1, y1 in rectangles:
        count[y0:y1, x0:x1] += 1
    return count


@pytest.mark.parametrize("count", [0, 1, 5, 20, 60])
@pytest.mark.parametrize("seed", range(5))
def test_merged_rectangles_hold_the_same_pixels_and_do_not_overlap(count: int, seed: int) -> None:
    rectangles = random_rectangles(count, seed)
    apart = merge_overlapping(rectangles)
    assert painted(apart).max() == min(count, 1)
    assert (painted(apart) >= np.minimum(painted(rectangles), 1)).all()
    assert len(apart) <= count
    assert enclosing_rectangle(apart) == enclosing_rectangle(rectangles)


def test_rectangles_that_do_not_overlap_are_unchanged() -> None:
    rectangles = [(0, 0, 5, 5), (5, 0, 9, 5), (0, 5, 9, 7)]
    for order in (rectangles, rectangles[::-1]):
        assert merge_overlapping(order) == order
    assert enclosing_rectangle([]) == (0, 0, 0, 0)
