import math
from typing import Any

import numpy as np
import pytest

from sim import Crossing, CrossingConfig
from sim.errors import SceneConfigError
from sim.geometry.pinhole import Intrinsics, Pose, project

POSE = Pose(np.array([0.0, -6.0, 1.0]))
LENS = Intrinsics()


def test_field_of_view_is_that_of_a_davis346_behind_6_mm() -> None:
    assert 2 * math.degrees(LENS.half_width_rad) == pytest.approx(56.2, abs=0.1)
    assert 2 * math.degrees(LENS.half_height_rad) == pytest.approx(43.7, abs=0.1)


def test_a_lens_may_have_oblong_pixels_and_an_axis_off_the_middle() -> None:
    lens = Intrinsics(100, 80, 50.0, aspect=2.0, axis_px=(10.0, -5.0))
    pixels, _ = project(np.array([[0.0, 0.0, 1.0], [1.0, -1.0, 3.0]]), POSE, lens)
    assert pixels[0] == pytest.approx([60, 35])
    assert pixels[1] == pytest.approx([60 + 50 / 5, 35 - 100 * 2 / 5])
    assert 2 * lens.half_width_rad == pytest.approx(math.atan(60 / 50) + math.atan(40 / 50))
    assert 2 * lens.half_height_rad == pytest.approx(math.atan(35 / 100) + math.atan(45 / 100))
    doubled = lens.scaled(2)
    assert project(np.array([[1.0, -1.0, 3.0]]), POSE, doubled)[0] == pytest.approx(2 * pixels[1:])


@pytest.mark.parametrize("more", [{"aspect": 1.1}, {"axis_px": (0.0, 1.0)}])
def test_a_crossing_needs_a_symmetric_lens(more: dict[str, Any]) -> None:
    LENS.require_symmetry()
    with pytest.raises(SceneConfigError, match=r"Allowed in a crossing are 1 and \(0, 0\)"):
        Crossing(CrossingConfig(), Intrinsics(**more))


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
