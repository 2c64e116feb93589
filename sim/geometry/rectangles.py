"""Rectangles of pixels: around points, around other rectangles, and without overlap."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Intrinsics, Pose

F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]
Point = F64 | tuple[float, float]
Rectangle = tuple[int, int, int, int]
"""x0, y0, x1, y1 of a rectangle of pixels, half-open [px]."""

MARGIN_PX = 2
"""Margin for the blur of the lens and for the neighbours that a pixel depends on [px] (assumed)."""


NOWHERE: Rectangle = (0, 0, 0, 0)
"""The rectangle of something outside the image, for kernels."""


class SteadyCamera(NamedTuple):
    """A steady camera without an offset of its optical axis, for kernels.

    Attributes:
        world_to_camera: (3, 4) transform from the world to the camera's frame.
        focal_px: focal length [px].
        width: width of the image [px].
        height: height of the image [px].
    """

    world_to_camera: F64
    focal_px: float
    width: int
    height: int


def steady_camera(pose: Pose, lens: Intrinsics) -> SteadyCamera:
    """Return a camera for kernels."""
    return SteadyCamera(pose.world_to_camera, lens.focal_px, lens.width, lens.height)


def rectangle_around(low: Point, high: Point, lens: Intrinsics) -> Rectangle | None:
    """Return the rectangle of pixels around a span of image coordinates; None outside the image.

    Args:
        low: (2,) lowest x and y [px].
        high: (2,) highest x and y [px].
        lens: intrinsics of the camera.
    """
    found = pixels_around(low[0], low[1], high[0], high[1], lens.width, lens.height)
    return None if found == NOWHERE else found


@compiled
def pixels_around(
    low_x: float, low_y: float, high_x: float, high_y: float, width: int, height: int
) -> Rectangle:
    """Return the rectangle of pixels around a span; `NOWHERE` outside the image.

    Args:
        low_x: lowest column of the span [px].
        low_y: lowest row [px].
        high_x: highest column [px].
        high_y: highest row [px].
        width: width of the image [px].
        height: height of the image [px].
    """
    x0 = int(min(max(np.floor(low_x) - MARGIN_PX, 0.0), float(width)))
    y0 = int(min(max(np.floor(low_y) - MARGIN_PX, 0.0), float(height)))
    x1 = int(min(max(np.ceil(high_x) + MARGIN_PX, 0.0), float(width)))
    y1 = int(min(max(np.ceil(high_y) + MARGIN_PX, 0.0), float(height)))
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else NOWHERE


def image_rectangle(lens: Intrinsics) -> Rectangle:
    """Return the rectangle of the whole image."""
    return 0, 0, lens.width, lens.height


def rectangle_of_points(points_m: F64, pose: Pose, lens: Intrinsics) -> Rectangle | None:
    """Return the rectangle that holds the convex hull of (n, 3) world points [m]."""
    found = hull_rectangle(points_m, steady_camera(pose, lens))
    return None if found == NOWHERE else found


def enclosing_rectangle(rectangles: list[Rectangle]) -> Rectangle:
    """Return the smallest rectangle that holds all; an empty one if there are none."""
    if not rectangles:
        return 0, 0, 0, 0
    x0, y0, x1, y1 = zip(*rectangles, strict=True)
    return min(x0), min(y0), max(x1), max(y1)


def merge_overlapping(rectangles: list[Rectangle]) -> list[Rectangle]:
    """Join overlapping rectangles until none overlap."""
    apart: list[Rectangle] = []
    for rectangle in rectangles:
        grown = rectangle
        while hit := next((w for w in apart if _overlap(w, grown)), None):
            apart.remove(hit)
            grown = enclosing_rectangle([hit, grown])
        apart.append(grown)
    return apart


def _overlap(a: Rectangle, b: Rectangle) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


@compiled
def joint_rectangles(bounds: F64, group: I64, count: int, width: int, height: int) -> I64:
    """Return the rectangle around each group of bounding boxes.

    Args:
        bounds: (n, 4) lowest x and y, highest x and y [px]; +∞ and -∞ for an empty box.
        group: (n,) number of the group that each box belongs to, -1 for none.
        count: number of groups.
        width: width of the image [px].
        height: height of the image [px].

    Returns:
        (count, 4) x0, y0, x1, y1 [px]; `NOWHERE` for a group outside the image.
    """
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    for box, k in zip(bounds, group):  # noqa: B905
        if k >= 0:
            for axis in range(2):
                low[k, axis] = min(low[k, axis], box[axis])
                high[k, axis] = max(high[k, axis], box[2 + axis])
    out = np.empty((count, 4), np.int64)
    for k in range(count):
        out[k] = pixels_around(low[k, 0], low[k, 1], high[k, 0], high[k, 1], width, height)
    return out


@compiled
def hull_rectangle(points_m: F64, camera: SteadyCamera) -> Rectangle:
    """Return the rectangle that holds the convex hull of points; `NOWHERE` outside the image.

    If the camera is among the points, it is the whole image.

    Args:
        points_m: (n, 3) points in the world [m].
        camera: the camera.
    """
    into, focal_px, width, height = camera
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
    if behind == len(points_m):
        return NOWHERE
    if behind > 0:
        return 0, 0, width, height
    x, y = width / 2, height / 2
    return pixels_around(x + low_x, y + low_y, x + high_x, y + high_y, width, height)
