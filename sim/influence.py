"""Which part of the image a vehicle can change: itself, its shadows, and what its lamps light.

Everything else is exactly as without it, so only this window need be drawn again.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim.camera import Intrinsics, project
from sim.renderer import Window
from sim.scene import Scene

MARGIN_PX = 3
"""Reach of the lens's blur and of the shadow map's filter (measured: nothing is beyond)."""
BEAM_REACH_M = 30.0
"""Farther ahead, dipped beams change nothing that is in view (measured)."""
BEAM_HEIGHT_M = 0.75
"""Dipped beams light nothing above their lamps, which are 0.66 m above the road."""
BEAM_HALF_WIDTH_M = 2.8
"""Across the road, what the cones light of what is in view (measured: 2.7 m)."""

Points = npt.NDArray[np.float64]


def influence_window(scene: Scene, position_m: float, intrinsics: Intrinsics) -> Window | None:
    """The window that a vehicle at `position_m` can change; None where it can change nothing."""
    body = body_window(scene, position_m, intrinsics)
    if not scene.has_beams:
        return body
    beam = _bounds(_beam(scene, position_m), scene, intrinsics)
    if body is None or beam is None:
        return body or beam
    (x0, y0, x1, y1), (u0, v0, u1, v1) = body, beam
    return min(x0, u0), min(y0, v0), max(x1, u1), max(y1, v1)


def body_window(scene: Scene, position_m: float, intrinsics: Intrinsics) -> Window | None:
    """The window that holds the vehicle and its shadows, without what its lamps light."""
    return _bounds(_body_and_shadows(scene, position_m), scene, intrinsics)


def _body_and_shadows(scene: Scene, position_m: float) -> Points:
    body = scene.body_corners_m(position_m)
    return np.concatenate([body, *(_shadow(body, caster) for caster in scene.casters_m)])


def _shadow(points_m: Points, caster: Points) -> Points:
    """Shadows on the ground of points below a light, given in homogeneous coordinates."""
    place, weight = caster[:3], caster[3]
    towards = place - weight * points_m
    height = points_m[:, 2:3]
    return np.asarray(points_m - towards * height / towards[:, 2:3])


def _beam(scene: Scene, position_m: float) -> Points:
    """Corners of a box ahead of the vehicle's tail that holds all that its beams light."""
    tail = scene.body_corners_m(position_m)[:, 0] * scene.heading
    ahead = np.array([tail.min(), tail.max() + BEAM_REACH_M]) * scene.heading
    across = [-BEAM_HALF_WIDTH_M, BEAM_HALF_WIDTH_M]
    box = np.meshgrid(ahead, across, [0.0, BEAM_HEIGHT_M])
    return np.array(box).reshape(3, -1).T


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
