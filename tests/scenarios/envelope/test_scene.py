"""Scenes of synthetic stimuli: motion of the layers."""

import numpy as np
import pytest

from flybench.direction import CARDINAL, Direction
from scenarios.envelope.scene import (
    DISTRACTOR_SCALE,
    LEAD_S,
    MAX_CROSSING_S,
    make_scene,
    visible_box,
)
from scenarios.envelope.stimulus import Background, Stimulus, Surface

VELOCITY: dict[Direction, tuple[int, int]] = {
    Direction.RIGHT: (1, 0),
    Direction.LEFT: (-1, 0),
    Direction.UP: (0, -1),
    Direction.DOWN: (0, 1),
}


@pytest.mark.parametrize("direction", CARDINAL)
def test_the_target_moves_with_the_given_velocity(direction: Direction) -> None:
    scene = make_scene(Stimulus(speed_px_s=400, direction=direction))
    times_us = np.array([300_000.0, 400_000.0])
    before, after = scene.corners_px(times_us)[:, -1]
    np.testing.assert_allclose(after - before, 40 * np.array(VELOCITY[direction]))


def test_a_target_enters_after_the_lead_and_leaves_at_the_end() -> None:
    scene = make_scene(Stimulus(speed_px_s=466))
    assert scene.duration_us == round((LEAD_S + 1) * 1e6)
    times_us = np.array([LEAD_S * 1e6 - 10, LEAD_S * 1e6 + 10_000, scene.duration_us - 10_000])
    out, entering, leaving = scene.target_px(times_us)
    assert out[0] == out[2] == 0
    assert entering[[0, 2]] == pytest.approx([0, 4.66])
    assert leaving[[0, 2]] == pytest.approx([346 - 4.66, 346])


def test_only_the_middle_of_a_slow_crossing_is_shown() -> None:
    scene = make_scene(Stimulus(speed_px_s=40, direction=Direction.DOWN))
    assert scene.duration_us == round((LEAD_S + MAX_CROSSING_S) * 1e6)
    middle = scene.target_px(np.array([(LEAD_S + MAX_CROSSING_S / 2) * 1e6]))[0]
    assert (middle[1] + middle[3]) / 2 == pytest.approx(130)
    assert middle[3] - middle[1] == pytest.approx(120)
    assert middle[2] - middle[0] == pytest.approx(48)


def test_a_distractor_moves_the_other_way_beside_the_target() -> None:
    scene = make_scene(Stimulus(speed_px_s=300, background=Background.DISTRACTOR))
    assert len(scene.layers) == 2
    times_us = np.array([0.0, 1e6])
    corners = scene.corners_px(times_us)
    travel = corners[1] - corners[0]
    np.testing.assert_allclose(travel, np.array([[-300 * DISTRACTOR_SCALE, 0], [300, 0]]))
    (_, y), (_, y_target) = corners[0]
    other, target = scene.layers[0].size_px, scene.layers[1].size_px
    assert y + other[1] < y_target or y > y_target + target[1]


def test_camera_shake_moves_the_whole_image() -> None:
    still = make_scene(Stimulus(seed=3))
    shaken = make_scene(Stimulus(seed=3, background=Background.SHAKE))
    times_us = np.linspace(0, 1e6, 50)
    image_shift_px = shaken.image_shift_px(times_us)
    assert abs(image_shift_px).max() > 1
    np.testing.assert_allclose(
        shaken.corners_px(times_us)[:, -1] - still.corners_px(times_us)[:, -1], image_shift_px
    )
    assert shaken.margin_px >= abs(image_shift_px).max() + 1
    assert (still.image_shift_px(times_us) == 0).all()


def test_trees_oscillate_beside_the_path() -> None:
    scene = make_scene(Stimulus(background=Background.WIND))
    corners = scene.corners_px(np.linspace(0, 1.7e6, 100))
    trees, target = corners[:, :-1], corners[:, -1]
    assert 0.5 < np.ptp(trees, axis=0).max() < 20
    for n, layer in enumerate(scene.layers[:-1]):
        below = trees[:, n, 1].min() > target[0, 1] + 48 - 15
        above = (trees[:, n, 1] + layer.size_px[1]).max() < target[0, 1] + 15
        assert below or above


@pytest.mark.parametrize("surface", Surface)
def test_the_texture_follows_the_direction_of_the_target(surface: Surface) -> None:
    right, left, up, down = (
        make_scene(Stimulus(direction=d, surface=surface)).layers[-1].texture for d in CARDINAL
    )
    np.testing.assert_array_equal(left, right[:, ::-1])
    np.testing.assert_array_equal(down, right.T)
    np.testing.assert_array_equal(up, right.T[::-1])


def test_the_seed_changes_texture_and_position() -> None:
    one, other = make_scene(Stimulus(seed=1)), make_scene(Stimulus(seed=2))
    assert not np.array_equal(one.layers[-1].texture, other.layers[-1].texture)
    assert one.layers[-1].centre_px != other.layers[-1].centre_px


def test_a_tilted_target_keeps_its_motion_and_its_visible_box_is_that_of_its_outline() -> None:
    straight, tilted = (
        make_scene(Stimulus(speed_px_s=400, surface=Surface.PLAIN, tilt_deg=tilt))
        for tilt in (0.0, 30.0)
    )
    times_us = np.array([650_000.0, 750_000.0])
    centres = [
        scene.corners_px(times_us)[:, -1] + scene.layers[-1].size_px / 2
        for scene in (straight, tilted)
    ]
    np.testing.assert_allclose(centres[0], centres[1])
    x0, y0, x1, y1 = tilted.target_px(times_us)[0]
    sine, cosine = np.sin(np.radians(30)), np.cos(np.radians(30))
    assert (x1 - x0, y1 - y0) == pytest.approx(
        (120 * cosine + 48 * sine, 120 * sine + 48 * cosine), abs=0.01
    )
    layer = tilted.layers[-1]
    rows, columns = np.nonzero(layer.opacity > 0.5)
    assert rows.size == pytest.approx(120 * 48, rel=0.01)
    assert np.corrcoef(columns, rows)[0, 1] > 0.5  # clockwise: its right end is lower


@pytest.mark.parametrize("direction", CARDINAL)
def test_a_band_crosses_the_whole_image_and_is_out_of_view_before_and_after(
    direction: Direction,
) -> None:
    scene = make_scene(
        Stimulus(speed_px_s=900, surface=Surface.BAND, direction=direction, tilt_deg=15.0)
    )
    before, middle = scene.target_px(np.array([0.0, scene.duration_us - scene.crossing_s * 5e5]))
    assert tuple(before) == (0, 0, 0, 0)
    across = 1 if VELOCITY[direction][0] else 0
    assert (middle[across], middle[across + 2]) == (0, (346, 260)[across])


def test_the_visible_box_is_that_of_the_part_in_the_image() -> None:
    diamond = np.array([(0, -5), (5, 0), (0, 5), (-5, 0)], np.float64)
    assert visible_box(diamond, width=10, height=8) == pytest.approx((0, 0, 5, 5))
    assert visible_box(diamond - 6, width=10, height=8) == (0, 0, 0, 0)
