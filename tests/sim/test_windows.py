"""Windows hold what they are to hold: points, shadows and beams, tried one by one."""

import math

import numpy as np
import numpy.typing as npt
import pytest

from sim.camera import Intrinsics, Pose, project
from sim.moves import axes_along
from sim.shadow_maps import Lamp
from sim.windows import (
    BEAM_REACH_M,
    MARGIN_PX,
    Window,
    beam_window,
    hull,
    merged,
    points_window,
    shadow_window,
    whole,
    window_around,
)

F64 = npt.NDArray[np.float64]

LENS = Intrinsics()
POSE = Pose(np.array([0.0, -7.0, 1.2]))


def holds(window: Window | None, points_m: F64) -> bool:
    """Whether a window holds all of some points that are in view."""
    pixels, depth = project(points_m, POSE, LENS)
    inside = (pixels >= 0) & (pixels < [LENS.width, LENS.height])
    pixels = pixels[(depth > 0.05) & inside.all(axis=1)]
    if window is None:
        return not len(pixels)
    x0, y0, x1, y1 = window
    return bool(((pixels >= [x0, y0]) & (pixels <= [x1, y1])).all())


def test_a_window_has_whole_pixels_and_a_margin_within_the_image() -> None:
    m = MARGIN_PX
    span = window_around(np.array([10.2, 20.0]), np.array([30.0, 40.7]), LENS)
    assert span == (10 - m, 20 - m, 30 + m, 41 + m)
    assert window_around(np.array([-9.0, -9.0]), np.array([999.0, 999.0]), LENS) == whole(LENS)
    assert window_around(np.array([346.0 + m, 0.0]), np.array([400.0, 9.0]), LENS) is None


def test_points_around_the_camera_may_be_anywhere_and_those_behind_it_nowhere() -> None:
    before, behind = np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, -9.0, 1.0]])
    assert points_window(np.concatenate([before, behind]), POSE, LENS) == whole(LENS)
    assert points_window(behind, POSE, LENS) is None


def boxes(count: int, seed: int) -> list[F64]:
    """(8, 3) corners each, on or above the ground."""
    random = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        low = random.uniform([-12, -2, 0], [12, 4, 1])
        high = low + random.uniform(0.2, 2, 3)
        found.append(np.array(np.meshgrid(*np.stack([low, high], axis=1))).reshape(3, -1).T)
    return found


def lamps(count: int, seed: int) -> list[Lamp]:
    random = np.random.default_rng(seed)
    found = []
    for k in range(count):
        direction = random.normal(size=3) - [0, 0, 2]
        direction[2] = -abs(direction[2])
        axes = axes_along(direction / np.linalg.norm(direction))
        place = random.uniform([-10, -5, 4], [10, 8, 8])
        found.append(Lamp(axes, place, parallel=k % 2 == 0))
    return found


@pytest.mark.parametrize("seed", range(8))
def test_a_shadow_lies_in_its_window(seed: int) -> None:
    random = np.random.default_rng(seed)
    small = 0
    for corners, lamp in zip(boxes(20, seed), lamps(20, seed), strict=True):
        window = shadow_window(corners, lamp, POSE, LENS)
        caster = random.uniform(corners.min(axis=0), corners.max(axis=0), (300, 3))
        away = np.tile(lamp.axes[2], (300, 1)) if lamp.parallel else caster - lamp.place_m
        to_ground = caster[:, 2] / -away[:, 2]
        down = random.uniform(size=(300, 1)) * to_ground[:, None]
        if (to_ground > 0).all():
            assert holds(window, caster + down * away)
        small += window is not None and window != whole(LENS)
    assert small >= 3


@pytest.mark.parametrize("seed", range(8))
def test_a_beam_lies_in_its_window(seed: int) -> None:
    """Up to its reach along its axis, and down to the ground."""
    random = np.random.default_rng(seed)
    small = 0
    for _ in range(20):
        place = random.uniform([-10, -1, 0.3], [10, 4, 1])
        direction = random.normal(size=3) * [1, 0.3, 0.1] - [0, 0, 0.1]
        direction /= np.linalg.norm(direction)
        angle = math.radians(random.uniform(3, 30))
        off = math.tan(angle) * np.sqrt(random.uniform(size=2000))
        turn = random.uniform(0, 2 * math.pi, 2000)
        axes = axes_along(direction)
        across = np.stack([off * np.cos(turn), off * np.sin(turn)], axis=1) @ axes[:2]
        reach = BEAM_REACH_M * random.uniform(size=(2000, 1))
        lit = place + reach * (direction + across)
        window = beam_window(place, direction, angle, POSE, LENS)
        assert holds(window, lit[lit[:, 2] >= 0])
        small += window is not None and window != whole(LENS)
    assert small >= 3


def random_windows(count: int, seed: int) -> list[Window]:
    random = np.random.default_rng(seed)
    low = random.integers(0, 90, (count, 2))
    high = low + random.integers(1, 12, (count, 2))
    return [(int(a), int(b), int(c), int(d)) for (a, b), (c, d) in zip(low, high, strict=True)]


def painted(windows: list[Window]) -> npt.NDArray[np.int64]:
    count = np.zeros((102, 102), np.int64)
    for x0, y0, x1, y1 in windows:
        count[y0:y1, x0:x1] += 1
    return count


@pytest.mark.parametrize("count", [0, 1, 5, 20, 60])
@pytest.mark.parametrize("seed", range(5))
def test_merged_windows_hold_the_same_and_do_not_overlap(count: int, seed: int) -> None:
    windows = random_windows(count, seed)
    apart = merged(windows)
    assert painted(apart).max() == min(count, 1)
    assert (painted(apart) >= np.minimum(painted(windows), 1)).all()
    assert len(apart) <= count
    assert hull(apart) == hull(windows)


def test_windows_that_do_not_overlap_stay_as_they_are() -> None:
    windows = [(0, 0, 5, 5), (5, 0, 9, 5), (0, 5, 9, 7)]
    for order in (windows, windows[::-1]):
        assert merged(order) == order
    assert hull([]) == (0, 0, 0, 0)
