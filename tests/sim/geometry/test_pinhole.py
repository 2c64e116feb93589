import math

import numpy as np
import pytest

from sim.geometry.pinhole import Intrinsics, Pose, project

POSE = Pose(np.array([0.0, -6.0, 1.0]))
LENS = Intrinsics()


def test_field_of_view_is_that_of_a_davis346_behind_6_mm() -> None:
    assert 2 * math.degrees(LENS.half_width_rad) == pytest.approx(56.2, abs=0.1)
    assert 2 * math.degrees(LENS.half_height_rad) == pytest.approx(43.7, abs=0.1)


def test_axes_of_the_image() -> None:
    points = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, -7.0, 1.0]])
    pixels, depth = project(points, POSE, LENS)
    assert pixels[0] == pytest.approx([173, 130])
    assert pixels[1] == pytest.approx([173 + LENS.focal_px / 6, 130])
    assert pixels[2] == pytest.approx([173, 130 - LENS.focal_px / 6])
    assert depth[:3] == pytest.approx(6)
    assert depth[3] < 0
    assert np.isnan(pixels[3]).all()


@pytest.mark.parametrize(
    ("quarter_turns", "image_axis"), [(1, (0, -1)), (-1, (0, 1)), (2, (-1, 0))]
)
def test_a_roll_turns_the_worlds_right(quarter_turns: int, image_axis: tuple[float, float]) -> None:
    rolled = POSE.rolled(quarter_turns * math.pi / 2)
    pixels, _ = project(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]), rolled, LENS)
    assert (pixels[1] - pixels[0]) * 6 / LENS.focal_px == pytest.approx(image_axis, abs=1e-9)
    assert rolled.forward == pytest.approx(POSE.forward)
