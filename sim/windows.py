"""Which parts of the image a moving object can change: where it is, its shadows, its beams."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from numba import njit

from sim.camera import Intrinsics, Pose
from sim.moves import axes_along
from sim.shadow_maps import Lamp

F64 = npt.NDArray[np.float64]
Window = tuple[int, int, int, int]
"""x0, y0, x1, y1 [px], half-open."""

MARGIN_PX = 2
"""Reach of the lens's blur, and of what a pixel asks of its neighbours."""
BEAM_REACH_M = 30.0
"""Farther ahead, dipped beams change nothing that is in view (measured)."""
BEAM_RIM = 24
"""Points around a beam's rim."""


def window_around(low: F64, high: F64, lens: Intrinsics) -> Window | None:
    """The window of pixels around a span of image coordinates; None outside of the image."""
    size = np.array([lens.width, lens.height])
    first = np.clip(np.floor(low) - MARGIN_PX, 0, size)
    last = np.clip(np.ceil(high) + MARGIN_PX, 0, size)
    if not (first < last).all():
        return None
    return int(first[0]), int(first[1]), int(last[0]), int(last[1])


def whole(lens: Intrinsics) -> Window:
    """The whole image."""
    return 0, 0, lens.width, lens.height


def points_window(points_m: F64, pose: Pose, lens: Intrinsics) -> Window | None:
    """The window that holds the convex hull of world points, (n, 3)."""
    low_x, low_y, high_x, high_y, behind = _span(points_m, pose.into, lens.focal_px)
    if behind == len(points_m):
        return None
    if behind:
        return whole(lens)
    middle = np.array([lens.width / 2, lens.height / 2])
    low, high = np.array([low_x, low_y]), np.array([high_x, high_y])
    return window_around(middle + low, middle + high, lens)


@njit(cache=True, error_model="numpy")
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


def shadow_window(corners_m: F64, lamp: Lamp, pose: Pose, lens: Intrinsics) -> Window | None:
    """The window that holds a box and all that it can shut out of a light, down to the ground."""
    if lamp.parallel:
        to_light = np.broadcast_to(-lamp.axes[2], corners_m.shape)
    else:
        to_light = lamp.place_m - corners_m
    if (to_light[:, 2] <= 0).any():
        return whole(lens)
    shadow = corners_m - to_light * (corners_m[:, 2:] / to_light[:, 2:])
    return points_window(np.concatenate([corners_m, shadow]), pose, lens)


def beam_window(
    place_m: F64, direction: F64, angle_rad: float, pose: Pose, lens: Intrinsics
) -> Window | None:
    """The window that holds all that a spot can light, above the ground.

    Args:
        place_m: (3,) in the world.
        direction: (3,) of the cone's axis, unit length.
        angle_rad: between the cone's axis and its rim.
        pose: the camera's.
        lens: likewise.
    """
    turn = np.arange(BEAM_RIM) * 2 * math.pi / BEAM_RIM
    radius = math.tan(angle_rad) / math.cos(math.pi / BEAM_RIM)  # around the circle, not inside
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1) @ axes_along(direction)[:2]
    rim = (direction + radius * circle) * BEAM_REACH_M
    after, falls = np.roll(rim, -1, axis=0), rim[:, 2] < -place_m[2]
    between = falls != np.roll(falls, -1)  # where the rim's edge meets the ground
    edge, along = rim[between], (after - rim)[between]
    ground = edge - along * ((place_m[2] + edge[:, 2]) / along[:, 2])[:, None]
    rim[falls] *= (-place_m[2] / rim[falls, 2])[:, None]
    return points_window(place_m + np.concatenate([np.zeros((1, 3)), rim, ground]), pose, lens)


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
