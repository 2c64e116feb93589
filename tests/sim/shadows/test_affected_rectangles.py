"""Shadows and beams lie inside the rectangles computed for them."""

import math

import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Intrinsics, Pose, project
from sim.geometry.rectangles import NOWHERE, image_rectangle, steady_camera
from sim.geometry.rigid_transform import axes_along
from sim.shadows.affected_rectangles import (
    BEAM_REACH_M,
    BeamLamps,
    ShadowLights,
    beams_in_view,
    shadow_rectangles,
)

F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]

LENS = Intrinsics()
POSE = Pose(np.array([0.0, -7.0, 1.2]))
FRAME = steady_camera(POSE, LENS)
TURN = POSE.world_to_camera[:, :3]


def holds(rectangle: I64, points_m: F64) -> bool:
    """Return True if a rectangle holds all of the points that are in view."""
    pixels, depth = project(points_m, POSE, LENS)
    inside = (pixels >= 0) & (pixels < [LENS.width, LENS.height])
    pixels = pixels[(depth > 0.05) & inside.all(axis=1)]
    return bool(((pixels >= rectangle[:2]) & (pixels <= rectangle[2:])).all())


def is_small(rectangle: I64) -> bool:
    """Return True if a rectangle is neither empty nor the whole image."""
    return tuple(rectangle.tolist()) not in (NOWHERE, image_rectangle(LENS))


def boxes(count: int, seed: int) -> F64:
    """Return random boxes on or above the ground, by their (count, 8, 3) corners."""
    random = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        low = random.uniform([-12, -2, 0], [12, 4, 1])
        high = low + random.uniform(0.2, 2, 3)
        found.append(np.array(np.meshgrid(*np.stack([low, high], axis=1))).reshape(3, -1).T)
    return np.array(found)


def shadow_lights(count: int, seed: int) -> ShadowLights:
    """Return suns and lamps in turn, in random positions and directions."""
    random = np.random.default_rng(seed)
    away, positions = [], []
    for _ in range(count):
        direction = random.normal(size=3) - [0, 0, 2]
        direction[2] = -abs(direction[2])
        away.append(direction / np.linalg.norm(direction))
        positions.append(random.uniform([-10, -5, 4], [10, 8, 8]))
    return ShadowLights(np.array(away), np.array(positions), np.arange(count) % 2 == 0)


@pytest.mark.parametrize("seed", range(8))
def test_a_shadow_lies_in_its_rectangle(seed: int) -> None:
    """The boxes are given in the frame of a body that has moved and turned."""
    random, small = np.random.default_rng(seed), 0
    boxes_m, lights = boxes(20, seed), shadow_lights(20, seed)
    turn, origin_m = axes_along(lights.away[3]), np.array([3.0, -1.0, 0.5])
    bodies = np.stack([np.zeros(3), origin_m]), np.stack([np.eye(3), turn]).reshape(2, 9)
    roots = np.ones(20, np.int64)
    own_m = (boxes_m - origin_m) @ turn
    found = shadow_rectangles(own_m, roots, *bodies, lights, FRAME)
    for corners, rectangles in zip(boxes_m, found, strict=True):
        caster = random.uniform(corners.min(axis=0), corners.max(axis=0), (300, 3))
        for k, rectangle in enumerate(rectangles):
            parallel = np.tile(lights.away[k], (300, 1))
            away = parallel if lights.is_sun[k] else caster - lights.positions_m[k]
            to_ground = caster[:, 2] / -away[:, 2]
            down = random.uniform(size=(300, 1)) * to_ground[:, None]
            if (to_ground > 0).all():
                assert holds(rectangle, caster + down * away)
            small += is_small(rectangle)
    assert small >= 60


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
        lamps = BeamLamps(np.array([1]), np.tan([angle]), np.array([[900.0, 7.0, -6.0]]))
        lights = np.stack([-position, position]), np.stack([-direction, direction])
        beams, areas = beams_in_view(lamps, *lights, FRAME)
        assert holds(areas[0] if len(areas) else np.array(NOWHERE), lit[lit[:, 2] >= 0])
        small += len(areas) > 0 and is_small(areas[0])
        for beam in beams:
            np.testing.assert_allclose(beam[:3], TURN @ (position - POSE.position_m))
            np.testing.assert_allclose(beam[3:6], TURN @ direction)
            assert beam[6:].tolist() == [900.0, 7.0, -6.0]
    assert small >= 3
