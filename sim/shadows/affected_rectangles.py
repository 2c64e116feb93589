"""Image rectangles that a moving object can change by its shadows and its beams."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rectangles import Rectangle, image_rectangle, rectangle_of_points
from sim.geometry.rigid_transform import axes_along
from sim.shadows.shadow_maps import ShadowSource

F64 = npt.NDArray[np.float64]

BEAM_REACH_M = 30.0
"""Distance beyond which a dipped beam changes nothing in view (measured)."""
BEAM_RIM_CORNERS = 24
"""Corners of the polygon that stands for a beam's circular rim. The polygon encloses the circle;
more corners only make the rectangle tighter, by 0.9 % of the radius at most (assumed)."""


def shadow_rectangle(
    corners_m: F64, source: ShadowSource, pose: Pose, lens: Intrinsics
) -> Rectangle | None:
    """Return the rectangle that holds a box and everything it can shade, down to the ground.

    Args:
        corners_m: (8, 3) corners of the box in the world [m].
        source: the sun or the lamp that the box shades.
        pose: pose of the camera.
        lens: intrinsics of the camera.

    Returns:
        The rectangle; the whole image if the shadow does not end on the ground; None if nothing of
        it is in the image.
    """
    points, on_ground = _add_shadows(corners_m, source.axes[2], source.position_m, source.is_sun)
    return rectangle_of_points(points, pose, lens) if on_ground else image_rectangle(lens)


def beam_rectangle(
    position_m: F64, direction: F64, angle_rad: float, pose: Pose, lens: Intrinsics
) -> Rectangle | None:
    """Return the rectangle that holds everything above the ground that a spot light can reach.

    Args:
        position_m: (3,) position of the spot light in the world [m].
        direction: (3,) unit vector along the cone's axis.
        angle_rad: angle between the cone's axis and its rim.
        pose: pose of the camera.
        lens: intrinsics of the camera.

    Returns:
        The rectangle; None if nothing of it is in the image.
    """
    points = _beam_hull(position_m, direction, axes_along(direction), math.tan(angle_rad))
    return rectangle_of_points(points, pose, lens)


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
