"""Rectangles of pixels: around points, around other rectangles, and without overlap."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Intrinsics, Pose

F64 = npt.NDArray[np.float64]
Point = F64 | tuple[float, float]
Rectangle = tuple[int, int, int, int]
"""x0, y0, x1, y1 of a rectangle of pixels, half-open [px]."""

MARGIN_PX = 2
"""Margin for the blur of the lens and for the neighbours that a pixel depends on [px] (assumed)."""


def rectangle_around(low: Point, high: Point, lens: Intrinsics) -> Rectangle | None:
    """Return the rectangle of pixels around a span of image coordinates; None outside the image.

    Args:
        low: (2,) lowest x and y [px].
        high: (2,) highest x and y [px].
        lens: intrinsics of the camera.
    """
    x0 = min(max(math.floor(low[0]) - MARGIN_PX, 0), lens.width)
    y0 = min(max(math.floor(low[1]) - MARGIN_PX, 0), lens.height)
    x1 = min(max(math.ceil(high[0]) + MARGIN_PX, 0), lens.width)
    y1 = min(max(math.ceil(high[1]) + MARGIN_PX, 0), lens.height)
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None


def image_rectangle(lens: Intrinsics) -> Rectangle:
    """Return the rectangle of the whole image."""
    return 0, 0, lens.width, lens.height


def rectangle_of_points(points_m: F64, pose: Pose, lens: Intrinsics) -> Rectangle | None:
    """Return the rectangle that holds the convex hull of (n, 3) world points [m]."""
    return _around(*_span(points_m, pose.world_to_camera, lens.focal_px), lens)


def _around(
    low_x: float, low_y: float, high_x: float, high_y: float, behind: int, lens: Intrinsics
) -> Rectangle | None:
    """Return the rectangle around the result of `_span`."""
    if behind:
        return image_rectangle(lens) if low_x <= high_x else None
    x, y = lens.width / 2, lens.height / 2
    return rectangle_around((x + low_x, y + low_y), (x + high_x, y + high_y), lens)


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
def _span(points_m: F64, into: F64, focal_px: float) -> tuple[float, float, float, float, int]:
    """Return the lowest and highest x and y of projected points from the optical axis [px].

    The last value is the number of points behind the camera.
    """
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
