"""Shadows and beams lie inside the rectangles computed for them."""

import math

import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Intrinsics, Pose, project
from sim.geometry.rectangles import Rectangle, image_rectangle
from sim.geometry.rigid_transform import axes_along
from sim.shadows.affected_rectangles import BEAM_REACH_M, beam_rectangle, shadow_rectangle
from sim.shadows.shadow_maps import ShadowSource

F64 = npt.NDArray[np.float64]

LENS = Intrinsics()
POSE = Pose(np.array([0.0, -7.0, 1.2]))


def holds(rectangle: Rectangle | None, points_m: F64) -> bool:
    """Return True if a rectangle holds all of the points that are in view."""
    pixels, depth = project(points_m, POSE, LENS)
    inside = (pixels >= 0) & (pixels < [LENS.width, LENS.height])
    pixels = pixels[(depth > 0.05) & inside.all(axis=1)]
    if rectangle is None:
        return not len(pixels)
    x0, y0, x1, y1 = rectangle
    return bool(((pixels >= [x0, y0]) & (pixels <= [x1, y1])).all())


def boxes(count: int, seed: int) -> list[F64]:
    """Return random boxes on or above the ground, by their (8, 3) corners."""
    random = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        low = random.uniform([-12, -2, 0], [12, 4, 1])
        high = low + random.uniform(0.2, 2, 3)
        found.append(np.array(np.meshgrid(*np.stack([low, high], axis=1))).reshape(3, -1).T)
    return found


def shadow_sources(count: int, seed: int) -> list[ShadowSource]:
    """Return suns and lamps in turn, in random positions and directions."""
    random = np.random.default_rng(seed)
    found = []
    for k in range(count):
        direction = random.normal(size=3) - [0, 0, 2]
        direction[2] = -abs(direction[2])
        axes = axes_along(direction / np.linalg.norm(direction))
        position = random.uniform([-10, -5, 4], [10, 8, 8])
        found.append(ShadowSource(axes, position, is_sun=k % 2 == 0))
    return found


@pytest.mark.parametrize("seed", range(8))
def test_a_shadow_lies_in_its_rectangle(seed: int) -> None:
    random = np.random.default_rng(seed)
    small = 0
    for corners, source in zip(boxes(20, seed), shadow_sources(20, seed), strict=True):
        rectangle = shadow_rectangle(corners, source, POSE, LENS)
        caster = random.uniform(corners.min(axis=0), corners.max(axis=0), (300, 3))
        away = np.tile(source.axes[2], (300, 1)) if source.is_sun else caster - source.position_m
        to_ground = caster[:, 2] / -away[:, 2]
        down = random.uniform(size=(300, 1)) * to_ground[:, None]
        if (to_ground > 0).all():
            assert holds(rectangle, caster + down * away)
        small += rectangle is not None and rectangle != image_rectangle(LENS)
    assert small >= 3


@pytest.mark.parametrize("seed", range(8))
def test_a_beam_lies_in_its_rectangle(seed: int) -> None:
    """The beam is followed up to its reach along its axis, and down to the ground."""
    random = np.random.default_rng(seed)
    small = 0
    for _ in range(20):
        position = random.uniform([-10, -1, 0.3], [10, 4, 1])
        direction = random.normal(size=3) * [1, 0.3, 0.1] - [0, 0, 0.1]
        direction /= np.linalg.norm(direction)
        angle = math.radians(random.uniform(3, 30))
        off = math.tan(angle) * np.sqrt(random.uniform(size=2000))
        turn = random.uniform(0, 2 * math.pi, 2000)
        axes = axes_along(direction)
        across = np.stack([off * np.cos(turn), off * np.sin(turn)], axis=1) @ axes[:2]
        reach = BEAM_REACH_M * random.uniform(size=(2000, 1))
        lit = position + reach * (direction + across)
        rectangle = beam_rectangle(position, direction, angle, POSE, LENS)
        assert holds(rectangle, lit[lit[:, 2] >= 0])
        small += rectangle is not None and rectangle != image_rectangle(LENS)
    assert small >= 3
