"""Image rectangles that a moving object can change by its shadows and its beams."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.rectangles import NOWHERE, Rectangle, SteadyCamera, hull_rectangle
from sim.geometry.rigid_transform import axes_along

F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

BEAM_REACH_M = 30.0
"""Distance beyond which a dipped beam changes nothing in view (measured)."""
BEAM_RIM_CORNERS = 24
"""Corners of the polygon that stands for a beam's circular rim. The polygon encloses the circle;
more corners only make the rectangle tighter, by 0.9 % of the radius at most (assumed)."""


class ShadowLights(NamedTuple):
    """Lights that cast shadows, for kernels; see `sim.shadows.shadow_maps.ShadowSource`.

    Attributes:
        away: (lights, 3) direction away from each light.
        positions_m: (lights, 3) position of each lamp [m]; arbitrary for the sun.
        is_sun: (lights,) bool, True for the sun.
    """

    away: F64
    positions_m: F64
    is_sun: Bools


@compiled
def shadow_rectangles(
    boxes_m: F64, roots: I64, origins_m: F64, axes: F64, lights: ShadowLights, camera: SteadyCamera
) -> I64:
    """Return the rectangles that hold boxes and everything they can shade, down to the ground.

    Args:
        boxes_m: (objects, 8, 3) corners of each object's box in the frame of its root body [m].
        roots: (objects,) numbers of these bodies.
        origins_m: (bodies, 3) origins of all bodies in the world [m].
        axes: (bodies, 9) rotation matrices of all bodies, row by row.
        lights: the lights.
        camera: the camera.

    Returns:
        (objects, lights, 4) x0, y0, x1, y1 [px]; the whole image if a shadow does not end on the
        ground; `NOWHERE` if nothing of it is in the image.
    """
    out = np.empty((len(boxes_m), len(lights.is_sun), 4), np.int64)
    corners_m = np.empty((8, 3))
    for k in range(len(boxes_m)):
        origin_m, turn = origins_m[roots[k]], axes[roots[k]]
        for i in range(8):
            x, y, z = boxes_m[k, i, 0], boxes_m[k, i, 1], boxes_m[k, i, 2]
            for axis in range(3):
                along = turn[3 * axis] * x + turn[3 * axis + 1] * y + turn[3 * axis + 2] * z
                corners_m[i, axis] = along + origin_m[axis]
        for j in range(len(lights.is_sun)):
            out[k, j] = _shadow_rectangle(corners_m, lights, j, camera)
    return out


class BeamLamps(NamedTuple):
    """Spot lights that move with the objects, for kernels.

    Attributes:
        numbers: (n,) numbers of the lights.
        slopes: (n,) tangent of the angle between each cone's axis and its rim.
        cones: (n, 3) candela, and scale and offset of each cone's edge.
    """

    numbers: I64
    slopes: F64
    cones: F64


@compiled
def beams_in_view(
    lamps: BeamLamps, positions_m: F64, directions: F64, camera: SteadyCamera
) -> tuple[F64, I64]:
    """Return the beams that reach something above the ground that is in the image.

    Args:
        lamps: the lights whose beams are looked for.
        positions_m: (lights, 3) positions of all lights in the world [m].
        directions: (lights, 3) unit vectors along all cones' axes.
        camera: the camera.

    Returns:
        (n, 9) position and direction in the camera's frame, and the cone, see `BeamLamps`; and
        (n, 4) x0, y0, x1, y1 of the area that each can light [px].
    """
    count, into = 0, camera.world_to_camera
    beams, areas = np.empty((len(lamps.numbers), 9)), np.empty((len(lamps.numbers), 4), np.int64)
    for k in range(len(lamps.numbers)):
        position_m, direction = positions_m[lamps.numbers[k]], directions[lamps.numbers[k]]
        hull_m = _beam_hull(position_m, direction, axes_along(direction), lamps.slopes[k])
        area = hull_rectangle(hull_m, camera)
        if area == NOWHERE:
            continue
        for i in range(3):
            along = into[i, 0] * position_m[0] + into[i, 1] * position_m[1]
            beams[count, i] = along + into[i, 2] * position_m[2] + into[i, 3]
            along = into[i, 0] * direction[0] + into[i, 1] * direction[1]
            beams[count, 3 + i] = along + into[i, 2] * direction[2]
        beams[count, 6:], areas[count] = lamps.cones[k], area
        count += 1
    return beams[:count], areas[:count]


@compiled
def _shadow_rectangle(
    corners_m: F64, lights: ShadowLights, light: int, camera: SteadyCamera
) -> Rectangle:
    """Return the rectangle of one box, (8, 3), and its shadow; see `shadow_rectangles`."""
    position_m, is_sun = lights.positions_m[light], lights.is_sun[light]
    points_m, on_ground = _add_shadows(corners_m, lights.away[light], position_m, is_sun)
    return hull_rectangle(points_m, camera) if on_ground else (0, 0, camera.width, camera.height)


@compiled
def _add_shadows(corners_m: F64, away: F64, position_m: F64, is_sun: bool) -> tuple[F64, bool]:
    """Return corners, followed by their shadows on the ground.

    Args:
        corners_m: (n, 3) [m].
        away: (3,) direction away from the sun.
        position_m: (3,) position of a lamp [m]; not used for the sun.
        is_sun: True for the sun.

    Returns:
        (2 n, 3) points [m]; and True if all shadows fall on the ground.
    """
    count = len(corners_m)
    out, on_ground = np.empty((2 * count, 3)), True
    for k in range(count):
        to_light = -away if is_sun else position_m - corners_m[k]
        on_ground &= to_light[2] > 0
        out[k] = corners_m[k]
        out[count + k] = corners_m[k] - to_light * (corners_m[k, 2] / to_light[2])
    return out, on_ground


@compiled
def _beam_hull(position_m: F64, direction: F64, axes: F64, slope: float) -> F64:
    """Return points whose convex hull holds the part of a cone that is above the ground.

    Args:
        position_m: (3,) tip of the cone [m].
        direction: (3,) unit vector along the cone's axis.
        axes: (3, 3) rows: two vectors across the axis, and the axis.
        slope: tangent of the angle between axis and rim.

    Returns:
        (n, 3) [m].
    """
    radius = slope / math.cos(math.pi / BEAM_RIM_CORNERS)  # encloses the circle
    rim = np.empty((BEAM_RIM_CORNERS, 3))
    for k in range(BEAM_RIM_CORNERS):
        angle = k * 2 * math.pi / BEAM_RIM_CORNERS
        across = math.cos(angle) * axes[0] + math.sin(angle) * axes[1]
        rim[k] = (direction + radius * across) * BEAM_REACH_M
    out, count = np.empty((1 + 2 * BEAM_RIM_CORNERS, 3)), 1
    out[0] = position_m
    for k in range(BEAM_RIM_CORNERS):
        edge, after = rim[k], rim[(k + 1) % BEAM_RIM_CORNERS]
        below_ground = edge[2] < -position_m[2]
        out[count] = position_m + edge * (-position_m[2] / edge[2] if below_ground else 1.0)
        count += 1
        if below_ground != (after[2] < -position_m[2]):  # the rim crosses the ground here
            along = after - edge
            out[count] = position_m + edge - along * ((position_m[2] + edge[2]) / along[2])
            count += 1
    return out[:count]
