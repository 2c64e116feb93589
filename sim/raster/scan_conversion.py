"""Scan conversion of triangles into a depth buffer.

The renderer computes luminance. Geometry alone is computed here, at a hundredth of the cost, so
that it can be computed anew at every sample. A buffer holds the label of the nearest triangle and
its nearness (1/depth) at each point of a regular grid.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.raster.triangle_rows import edge_slopes, row_span, sort_corners_by_row

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]

NO_LABEL = -1
"""Label of a grid point that no triangle covers."""


def empty_buffer(height: int, width: int) -> tuple[F32, I32]:
    """Return an empty buffer.

    Returns:
        Nearness, (height, width) float32, all 0; and labels, (height, width) int32, all `NO_LABEL`.
    """
    return np.zeros((height, width), np.float32), np.full((height, width), NO_LABEL, np.int32)


@compiled
def project_triangles(
    corners: F64, focal: float, centre_x: float, centre_y: float, near: float
) -> tuple[F64, I32]:
    """Project triangles and clip them at the near plane.

    Args:
        corners: (n, 3, 3) corners of the triangles in the camera's frame: right, down, forward [m].
        focal: focal length [grid points].
        centre_x: column where the optical axis meets the grid [grid points].
        centre_y: row where the optical axis meets the grid [grid points].
        near: distance of the near plane [m].

    Returns:
        (m, 3, 3) x, y [grid points] and 1/depth [1/m] of each corner; and (m,) the index of the
        triangle that each comes from. A triangle that the near plane cuts gives one or two.
    """
    out = np.empty((2 * len(corners), 3, 3))
    source = np.empty(2 * len(corners), np.int32)
    clipped = np.empty((4, 3))
    count = 0
    for t in range(len(corners)):
        inside = 0
        for i in range(3):
            inside += corners[t, i, 2] >= near
        if inside == 0:
            continue
        size = 3 if inside == 3 else clip_triangle(corners, t, near, clipped)
        for fan in range(size - 2):
            for i in range(3):
                k = 0 if i == 0 else fan + i
                if inside == 3:
                    x, y, z = corners[t, k, 0], corners[t, k, 1], corners[t, k, 2]
                else:
                    x, y, z = clipped[k, 0], clipped[k, 1], clipped[k, 2]
                nearness = 1.0 / z
                out[count, i, 0] = centre_x + focal * x * nearness
                out[count, i, 1] = centre_y + focal * y * nearness
                out[count, i, 2] = nearness
            source[count] = t
            count += 1
    return out[:count], source[:count]


@compiled
def clip_triangle(corners: F64, t: int, near: float, clipped: F64) -> int:
    """Clip triangle `t` of (n, 3, 3) corners at the near plane.

    Returns:
        Number of corners written to `clipped`, (4, 3): 3 or 4, or 0 behind the plane.
    """
    size = 0
    for i in range(3):
        j = (i + 1) % 3
        here, there = corners[t, i, 2], corners[t, j, 2]
        if here >= near:
            for axis in range(3):
                clipped[size, axis] = corners[t, i, axis]
            size += 1
        if (here >= near) != (there >= near):
            share = (near - here) / (there - here)
            for axis in range(3):
                begin, end = corners[t, i, axis], corners[t, j, axis]
                clipped[size, axis] = begin + share * (end - begin)
            size += 1
    return size


@compiled
def rasterise(
    triangles: F64, labels: I32, x0: int, y0: int, nearness: F32, label: I32, one_sided: bool
) -> None:
    """Rasterise triangles into a buffer, in place. The nearest triangle wins.

    Grid point (i, j) lies at (i + ½, j + ½). A triangle covers the points inside it. A point on an
    edge that two triangles share is covered by exactly one of them.

    Args:
        triangles: (n, 3, 3) x, y [grid points], and a nearness that is linear across the grid and
            falls with distance: 1/depth in perspective [1/m].
        labels: (n,) label to write where a triangle is visible.
        x0: column of the buffer's first point.
        y0: row of the buffer's first point.
        nearness: (height, width), nearness of the buffer.
        label: (height, width), labels of the buffer; (0, 0) if only nearness is wanted.
        one_sided: skip triangles that are seen from behind (clockwise, y down).
    """
    height, width = nearness.shape
    labelled = label.size > 0
    starts, stops = np.empty(height, np.int64), np.empty(height, np.int64)
    for t in range(len(triangles)):
        ax, ay, az = triangles[t, 0, 0], triangles[t, 0, 1], triangles[t, 0, 2]
        bx, by, bz = triangles[t, 1, 0], triangles[t, 1, 1], triangles[t, 1, 2]
        cx, cy, cz = triangles[t, 2, 0], triangles[t, 2, 1], triangles[t, 2, 2]
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if area == 0.0 or (one_sided and area > 0.0):
            continue
        first = max(math.ceil(min(ay, by, cy) - 0.5 - y0), 0)
        last = min(math.ceil(max(ay, by, cy) - 0.5 - y0), height)
        if first >= last:
            continue
        slope_x = ((bz - az) * (cy - ay) - (cz - az) * (by - ay)) / area
        slope_y = ((cz - az) * (bx - ax) - (bz - az) * (cx - ax)) / area
        triangle_label, start_x, start_y = labels[t], ax, ay
        ax, ay, bx, by, cx, cy = sort_corners_by_row(ax, ay, bx, by, cx, cy)
        long_slope, upper_slope, lower_slope = edge_slopes(ax, ay, bx, by, cx, cy)
        for row in range(first, last):
            y = row + y0 + 0.5
            low, high = row_span(ax, ay, bx, by, long_slope, upper_slope, lower_slope, y)
            starts[np.uintp(row)] = max(math.ceil(low - 0.5 - x0), 0)
            stops[np.uintp(row)] = min(math.ceil(high - 0.5 - x0), width)
        for row in range(first, last):
            start, stop = starts[np.uintp(row)], stops[np.uintp(row)]
            y = row + y0 + 0.5
            i = np.uintp(row)
            near_start = az + slope_x * (start + x0 + 0.5 - start_x) + slope_y * (y - start_y)
            for column in range(start, stop):
                j = np.uintp(column)
                near = np.float32(near_start + slope_x * (column - start))
                old = nearness[i, j]
                closer = near > old
                nearness[i, j] = near if closer else old
                if labelled:
                    label[i, j] = triangle_label if closer else label[i, j]


@compiled
def mark_covered(
    corners_xy: F64, faces: I32, x0: float, y0: float, stride: float, covered: Bools
) -> int:
    """Mark the grid points inside triangles that face the camera, in place.

    Grid point (i, j) lies at (x0 + i · stride, y0 + j · stride).

    Args:
        corners_xy: (n, 2) coordinates of corners. Triangles with a NaN corner are skipped.
        faces: (m, 3) corner indices of the triangles, anticlockwise as seen from outside.
        x0: column of the first grid point.
        y0: row of the first grid point.
        stride: distance between grid points.
        covered: (height, width), set to true at covered points.

    Returns:
        Number of newly marked points.
    """
    height, width = covered.shape
    count = 0
    for k in range(len(faces)):
        a, b, c = faces[k, 0], faces[k, 1], faces[k, 2]
        ax, ay, bx, by = corners_xy[a, 0], corners_xy[a, 1], corners_xy[b, 0], corners_xy[b, 1]
        cx, cy = corners_xy[c, 0], corners_xy[c, 1]
        if not (bx - ax) * (cy - ay) - (cx - ax) * (by - ay) < 0.0:
            continue
        first = max(math.ceil((min(ay, by, cy) - y0) / stride), 0)
        last = min(math.ceil((max(ay, by, cy) - y0) / stride), height)
        if first >= last:
            continue
        ax, ay, bx, by, cx, cy = sort_corners_by_row(ax, ay, bx, by, cx, cy)
        long_slope, upper_slope, lower_slope = edge_slopes(ax, ay, bx, by, cx, cy)
        for row in range(first, last):
            y = y0 + row * stride
            low, high = row_span(ax, ay, bx, by, long_slope, upper_slope, lower_slope, y)
            start = max(math.ceil((low - x0) / stride), 0)
            for column in range(start, min(math.ceil((high - x0) / stride), width)):
                count += not covered[row, column]
                covered[row, column] = True
    return count


@compiled
def transform_points(points: F64, body: I32, transforms: F64) -> F64:
    """Apply to each point the rigid transform of its body.

    Args:
        points: (n, 3) in their bodies' frames [m].
        body: (n,) number of the body that each point belongs to.
        transforms: (bodies, 3, 4) rotation and translation of each body.

    Returns:
        (n, 3) transformed points.
    """
    out = np.empty_like(points)
    for k in range(len(points)):
        b = body[k]
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        for axis in range(3):
            out[k, axis] = (
                transforms[b, axis, 0] * x
                + transforms[b, axis, 1] * y
                + transforms[b, axis, 2] * z
                + transforms[b, axis, 3]
            )
    return out


@compiled
def label_bounds(triangles: F64, labels: I32, count: int) -> F64:
    """Return the bounding box of each label's triangles.

    Args:
        triangles: (n, 3, 3) x, y and nearness [grid points].
        labels: (n,) label of each triangle, below `count`.
        count: number of labels.

    Returns:
        (count, 4) lowest x and y, highest x and y. A label without triangles has lowest values of
        +∞ and highest values of −∞.
    """
    out = np.empty((count, 4))
    out[:, :2] = np.inf
    out[:, 2:] = -np.inf
    for t in range(len(triangles)):
        k = labels[t]
        for i in range(3):
            for axis in range(2):
                out[k, axis] = min(out[k, axis], triangles[t, i, axis])
                out[k, 2 + axis] = max(out[k, 2 + axis], triangles[t, i, axis])
    return out
