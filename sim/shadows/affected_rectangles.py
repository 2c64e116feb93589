"""The parts of the image that a moving object can change by its shadows and its beams."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rectangles import Rectangle, points_rectangle, whole
from sim.geometry.rigid_transform import axes_along
from sim.shadows.shadow_maps import Lamp

F64 = npt.NDArray[np.float64]

BEAM_REACH_M = 30.0
"""Farther ahead, dipped beams change nothing that is in view (measured)."""
BEAM_RIM = 24
"""Corners of the polygon that stands for a beam's rim; it is drawn around the circle, so that more
of them only make the rectangle tighter, by 0.9 % of the radius at most (assumed)."""


def shadow_rectangle(corners_m: F64, lamp: Lamp, pose: Pose, lens: Intrinsics) -> Rectangle | None:
    """The rectangle that holds a box and all that it can shut out of a light, down to the ground.

    Args:
        corners_m: (8, 3) of the box, in the world [m].
        lamp: the light.
        pose: the camera's.
        lens: likewise.
    """
    points, falls = _with_shadow(corners_m, lamp.axes[2], lamp.place_m, lamp.parallel)
    return points_rectangle(points, pose, lens) if falls else whole(lens)


def beam_rectangle(
    place_m: F64, direction: F64, angle_rad: float, pose: Pose, lens: Intrinsics
) -> Rectangle | None:
    """The rectangle that holds all that a spot can light, above the ground.

    Args:
        place_m: (3,) in the world [m].
        direction: (3,) of the cone's axis, unit length.
        angle_rad: between the cone's axis and its rim.
        pose: the camera's.
        lens: likewise.
    """
    lit = _lit_hull(place_m, direction, axes_along(direction), math.tan(angle_rad))
    return points_rectangle(lit, pose, lens)


@compiled
def _with_shadow(corners_m: F64, away: F64, place_m: F64, parallel: bool) -> tuple[F64, bool]:
    """Corners, and after them their shadows on the ground.

    Args:
        corners_m: (n, 3) [m].
        away: (3,) from the light, if that is the sun.
        place_m: (3,) where it is, if not [m].
        parallel: whether it is the sun.

    Returns:
        (2 n, 3); and whether all shadows fall there.
    """
    count = len(corners_m)
    out, falls = np.empty((2 * count, 3)), True
    for k in range(count):
        to_light = -away if parallel else place_m - corners_m[k]
        falls &= to_light[2] > 0
        out[k] = corners_m[k]
        out[count + k] = corners_m[k] - to_light * (corners_m[k, 2] / to_light[2])
    return out, falls


@compiled
def _lit_hull(place_m: F64, direction: F64, axes: F64, slope: float) -> F64:
    """Points around a cone down to the ground, whose convex hull holds all of it above.

    Args:
        place_m: (3,) of its tip [m].
        direction: (3,) of its axis, unit length.
        axes: (3, 3) rows: two across, and the axis.
        slope: tangent of the angle between axis and rim.

    Returns:
        (n, 3) [m].
    """
    radius = slope / math.cos(math.pi / BEAM_RIM)  # around the circle, not inside
    rim = np.empty((BEAM_RIM, 3))
    for k in range(BEAM_RIM):
        turn = k * 2 * math.pi / BEAM_RIM
        across = math.cos(turn) * axes[0] + math.sin(turn) * axes[1]
        rim[k] = (direction + radius * across) * BEAM_REACH_M
    out, count = np.empty((1 + 2 * BEAM_RIM, 3)), 1
    out[0] = place_m
    for k in range(BEAM_RIM):
        edge, after = rim[k], rim[(k + 1) % BEAM_RIM]
        falls = edge[2] < -place_m[2]
        out[count] = place_m + edge * (-place_m[2] / edge[2] if falls else 1.0)
        count += 1
        if falls != (after[2] < -place_m[2]):  # the rim's edge meets the ground
            along = after - edge
            out[count] = place_m + edge - along * ((place_m[2] + edge[2]) / along[2])
            count += 1
    return out[:count]
