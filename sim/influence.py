"""Which part of the image moving objects can change: themselves, shadows, what lamps light.

Everything else is exactly as without it, so only this window need be drawn again.
"""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np
import numpy.typing as npt

from sim.camera import Intrinsics, project
from sim.objects import TREE, MovingObject
from sim.renderer import Window
from sim.scene import Scene

MARGIN_PX = 3
"""Reach of the lens's blur and of the shadow map's filter (measured: nothing is beyond)."""
FRINGE_M = 0.05
"""Around an object's box, what its shadow's soft edge may reach besides (measured likewise)."""
BEAM_REACH_M = 40.0
"""Farther ahead, dipped beams change nothing that is in view (measured)."""
BEAM_HEIGHT_M = 1.0
"""Dipped beams light nothing above their lamps, which are 0.9 m above the road at most."""
BEAM_HALF_WIDTH_M = 9.0
"""Across the road, what the spread beam's cone lights within 30 m."""

Points = npt.NDArray[np.float64]


def influence_window(scene: Scene, t_s: float, intrinsics: Intrinsics) -> Window | None:
    """The window that what moves can change at a time; None where it can change nothing."""
    if changes_everywhere(scene):
        return 0, 0, intrinsics.width, intrinsics.height
    windows = [body_window(scene, t_s, intrinsics)]
    data = _placed(scene, t_s)
    windows += [
        _bounds(_beam(item, data), scene, intrinsics) for item in scene.objects if item.lamps.size
    ]
    return _union(windows)


def body_window(scene: Scene, t_s: float, intrinsics: Intrinsics) -> Window | None:
    """The window that holds the moving objects and their shadows, without what lamps light."""
    data = _placed(scene, t_s)
    return _union(
        [_bounds(_body_and_shadows(scene, item, data), scene, intrinsics) for item in scene.objects]
    )


def changes_everywhere(scene: Scene) -> bool:
    """Whether the camera shakes, lamps flicker or trees move, so that no window holds it all."""
    swaying = any(item.kind == TREE for item in scene.objects)
    return scene.shake is not None or scene.flicker is not None or swaying


def _placed(scene: Scene, t_s: float) -> mujoco.MjData:
    data = mujoco.MjData(scene.model)
    scene.place(data, t_s)
    return data


def _body_and_shadows(scene: Scene, item: MovingObject, data: mujoco.MjData) -> Points:
    body = item.corners_m(data, fringe_m=FRINGE_M)
    return np.concatenate(
        [item.corners_m(data), *(_shadow(body, caster) for caster in scene.casters_m)]
    )


def _shadow(points_m: Points, caster: Points) -> Points:
    """Shadows on the ground of points below a light, given in homogeneous coordinates."""
    place, weight = caster[:3], caster[3]
    towards = place - weight * points_m
    height = points_m[:, 2:3]
    return np.asarray(points_m - towards * height / towards[:, 2:3])


def _beam(item: MovingObject, data: mujoco.MjData) -> Points:
    """Corners of a box ahead of a vehicle's tail that holds all that its beams light."""
    forward = np.sign(data.xmat[item.root, 0])
    tail = item.corners_m(data)[:, 0] * forward
    ahead = np.array([tail.min(), tail.max() + BEAM_REACH_M]) * forward
    across = data.xpos[item.root, 1] + np.array([-BEAM_HALF_WIDTH_M, BEAM_HALF_WIDTH_M])
    box = np.meshgrid(ahead, across, [0.0, BEAM_HEIGHT_M])
    return np.array(box).reshape(3, -1).T


def _union(windows: Iterable[Window | None]) -> Window | None:
    found = np.array([window for window in windows if window is not None])
    if not found.size:
        return None
    low, high = found[:, :2].min(axis=0), found[:, 2:].max(axis=0)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def _bounds(points_m: Points, scene: Scene, intrinsics: Intrinsics) -> Window | None:
    pixels, depth = project(points_m, scene.pose, intrinsics)
    if (depth <= 0).any():
        return 0, 0, intrinsics.width, intrinsics.height
    size = np.array([intrinsics.width, intrinsics.height])
    low = np.clip(np.floor(pixels.min(axis=0)) - MARGIN_PX, 0, size).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=0)) + MARGIN_PX, 0, size).astype(int)
    if (low >= high).any():
        return None
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])
