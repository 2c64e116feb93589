"""Which parts of the image a moving object can change: where it is, its shadows, its beams."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from kernels import compiled
from sim.camera import Intrinsics, Pose
from sim.moves import axes_along
from sim.shadow_maps import Lamp

F64 = npt.NDArray[np.float64]
Point = F64 | tuple[float, float]
Window = tuple[int, int, int, int]
"""x0, y0, x1, y1 [px], half-open."""

MARGIN_PX = 2
"""Reach of the lens's blur, and of what a pixel asks of its neighbours (assumed)."""
BEAM_REACH_M = 30.0
"""Farther ahead, dipped beams change nothing that is in view (measured)."""
BEAM_RIM = 24
"""Corners of the polygon that stands for a beam's rim; it is drawn around the circle, so that more
of them only make the window tighter, by 0.9 % of the radius at most (assumed)."""


def window_around(low: Point, high: Point, lens: Intrinsics) -> Window | None:
    """The window of pixels around a span of image coordinates; None outside of the image.

    Args:
        low: (2,) lowest x and y [px].
        high: (2,) highest.
        lens: the camera's.
    """
    x0 = min(max(math.floor(low[0]) - MARGIN_PX, 0), lens.width)
    y0 = min(max(math.floor(low[1]) - MARGIN_PX, 0), lens.height)
    x1 = min(max(math.ceil(high[0]) + MARGIN_PX, 0), lens.width)
    y1 = min(max(math.ceil(high[1]) + MARGIN_PX, 0), lens.height)
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None


def whole(lens: Intrinsics) -> Window:
    """The whole image."""
    return 0, 0, lens.width, lens.height


def points_window(points_m: F64, pose: Pose, lens: Intrinsics) -> Window | None:
    """The window that holds the convex hull of world points, (n, 3) [m]."""
    return _around(*_span(points_m, pose.into, lens.focal_px), lens)


def shadow_window(corners_m: F64, lamp: Lamp, pose: Pose, lens: Intrinsics) -> Window | None:
    """The window that holds a box and all that it can shut out of a light, down to the ground.

    Args:
        corners_m: (8, 3) of the box, in the world [m].
        lamp: the light.
        pose: the camera's.
        lens: likewise.
    """
    points, falls = _with_shadow(corners_m, lamp.axes[2], lamp.place_m, lamp.parallel)
    return points_window(points, pose, lens) if falls else whole(lens)


def beam_window(
    place_m: F64, direction: F64, angle_rad: float, pose: Pose, lens: Intrinsics
) -> Window | None:
    """The window that holds all that a spot can light, above the ground.

    Args:
        place_m: (3,) in the world [m].
        direction: (3,) of the cone's axis, unit length.
        angle_rad: between the cone's axis and its rim.
        pose: the camera's.
        lens: likewise.
    """
    lit = _lit_hull(place_m, direction, axes_along(direction), math.tan(angle_rad))
    return points_window(lit, pose, lens)


def _around(
    low_x: float, low_y: float, high_x: float, high_y: float, behind: int, lens: Intrinsics
) -> Window | None:
    """The window around what `_span` found."""
    if behind:
        return whole(lens) if low_x <= high_x else None
    x, y = lens.width / 2, lens.height / 2
    return window_around((x + low_x, y + low_y), (x + high_x, y + high_y), lens)


def hull(windows: list[Window]) -> Window:
    """The smallest window that holds all; one without pixels where there are none."""
    if not windows:
        return 0, 0, 0, 0
    x0, y0, x1, y1 = zip(*windows, strict=True)
    return min(x0), min(y0), max(x1), max(y1)


def merged(windows: list[Window]) -> list[Window]:
    """Windows that hold the same pixels and do not overlap."""
    apart: list[Window] = []
    for window in windows:
        grown = window
        while hit := next((w for w in apart if _overlap(w, grown)), None):
            apart.remove(hit)
            grown = hull([hit, grown])
        apart.append(grown)
    return apart


def _overlap(a: Window, b: Window) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


@compiled
def _span(points_m: F64, into: F64, focal_px: float) -> tuple[float, float, float, float, int]:
    """Least and greatest x and y of projected points from the axis [px]; how many lie behind."""
    low_x = low_y = math.inf
    high_x = high_y = -math.inf
    behind = 0
    for k in range(len(points_m)):
        a, b, c = points_m[k, 0], points_m[k, 1], points_m[k, 2]
        depth = into[2, 0] * a + into[2, 1] * b + into[2, 2] * c + into[2, 3]
        if depth <= 0.0:
            behind += 1
            continue
        scale = focal_px / depth
        x = scale * (into[0, 0] * a + into[0, 1] * b + into[0, 2] * c + into[0, 3])
        y = scale * (into[1, 0] * a + into[1, 1] * b + into[1, 2] * c + into[1, 3])
        low_x, high_x = min(low_x, x), max(high_x, x)
        low_y, high_y = min(low_y, y), max(high_y, y)
    return low_x, low_y, high_x, high_y, behind


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
