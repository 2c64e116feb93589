"""Exact visibility: triangles scan-converted into a depth buffer, as often as the scene moves.

The renderer draws light; where things are is drawn here, at a hundredth of the cost. A buffer
holds, for every point of a regular grid, which triangle is nearest and how near.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.raster.triangle_rows import crossings, from_top, slopes

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]

NOTHING = -1
"""What a buffer shows where no triangle is."""


def empty_buffer(height: int, width: int) -> tuple[F32, I32]:
    """Nearness, (height, width) float32 of zeros, and labels, the same of `NOTHING`, int32."""
    return np.zeros((height, width), np.float32), np.full((height, width), NOTHING, np.int32)


@compiled
def perspective(
    corners: F64, focal: float, centre_x: float, centre_y: float, near: float
) -> tuple[F64, I32]:
    """Project triangles, cut off at the near plane.

    Args:
        corners: (n, 3, 3) triangles by corner; right, down and forward of the eye [m].
        focal: focal length [grid points].
        centre_x: where the optical axis meets the grid [grid points].
        centre_y: likewise.
        near: distance of the near plane [m].

    Returns:
        (m, 3, 3) x, y [grid points] and 1/depth [1/m] of each corner, and (m,) which of the
        triangles each came from; one that the plane cuts makes one or two.
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
        size = 3 if inside == 3 else _clip(corners, t, near, clipped)
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
def _clip(corners: F64, t: int, near: float, clipped: F64) -> int:
    """Cut triangle `t` off at the near plane; the number of corners written to `clipped`."""
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
    """Draw triangles into a buffer, in place; the nearest wins.

    A grid point (i, j) lies at (i + ½, j + ½). A triangle covers the points inside of it and, of
    those on an edge that two share, each one's own.

    Args:
        triangles: (n, 3, 3) x, y [grid points], and what falls linearly across the grid with
            distance: 1/depth in perspective [1/m].
        labels: (n,) what to write where a triangle is seen.
        x0: column of the buffer's first point.
        y0: row likewise.
        nearness: (height, width), the buffer.
        label: (height, width), the buffer.
        one_sided: leave out triangles that are seen from behind (clockwise, y down).
    """
    height, width = nearness.shape
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
        what, start_x, start_y = labels[t], ax, ay
        ax, ay, bx, by, cx, cy = from_top(ax, ay, bx, by, cx, cy)
        whole, upper, lower = slopes(ax, ay, bx, by, cx, cy)
        for row in range(first, last):
            y = row + y0 + 0.5
            low, high = crossings(ax, ay, bx, by, whole, upper, lower, y)
            start = max(math.ceil(low - 0.5 - x0), 0)
            stop = min(math.ceil(high - 0.5 - x0), width)
            near = az + slope_x * (start + x0 + 0.5 - start_x) + slope_y * (y - start_y)
            for column in range(start, stop):
                if near > nearness[row, column]:
                    nearness[row, column] = near
                    label[row, column] = what
                near += slope_x


@compiled
def cover(flat: F64, faces: I32, x0: float, y0: float, stride: float, covered: Bools) -> int:
    """Mark the grid points inside of triangles that face the eye, in place.

    Grid point (i, j) lies at (x0 + i · stride, y0 + j · stride).

    Args:
        flat: (n, 2) corners; triangles with one that is not a number are left out.
        faces: (m, 3) triangles, anticlockwise as seen from outside.
        x0: column of the first grid point.
        y0: its row.
        stride: from one to the next.
        covered: (height, width), set to true.

    Returns:
        How many points are newly marked.
    """
    height, width = covered.shape
    count = 0
    for k in range(len(faces)):
        a, b, c = faces[k, 0], faces[k, 1], faces[k, 2]
        ax, ay, bx, by = flat[a, 0], flat[a, 1], flat[b, 0], flat[b, 1]
        cx, cy = flat[c, 0], flat[c, 1]
        if not (bx - ax) * (cy - ay) - (cx - ax) * (by - ay) < 0.0:
            continue
        first = max(math.ceil((min(ay, by, cy) - y0) / stride), 0)
        last = min(math.ceil((max(ay, by, cy) - y0) / stride), height)
        if first >= last:
            continue
        ax, ay, bx, by, cx, cy = from_top(ax, ay, bx, by, cx, cy)
        whole, upper, lower = slopes(ax, ay, bx, by, cx, cy)
        for row in range(first, last):
            y = y0 + row * stride
            low, high = crossings(ax, ay, bx, by, whole, upper, lower, y)
            start = max(math.ceil((low - x0) / stride), 0)
            for column in range(start, min(math.ceil((high - x0) / stride), width)):
                count += not covered[row, column]
                covered[row, column] = True
    return count


@compiled
def transform(triangles: F64, body: I32, moves: F64) -> F64:
    """Move triangles, each with its body.

    Args:
        triangles: (n, 3, 3) in their bodies' frames [m].
        body: (n,) which body each belongs to.
        moves: (bodies, 3, 4) rotation and translation.

    Returns:
        (n, 3, 3).
    """
    out = np.empty_like(triangles)
    for t in range(len(triangles)):
        b = body[t]
        for i in range(3):
            x, y, z = triangles[t, i, 0], triangles[t, i, 1], triangles[t, i, 2]
            for axis in range(3):
                out[t, i, axis] = (
                    moves[b, axis, 0] * x
                    + moves[b, axis, 1] * y
                    + moves[b, axis, 2] * z
                    + moves[b, axis, 3]
                )
    return out


@compiled
def bounds(triangles: F64, labels: I32, count: int) -> F64:
    """What each label's triangles span.

    Args:
        triangles: (n, 3, 3) x, y and nearness [grid points].
        labels: (n,) of each triangle, below `count`.
        count: of labels.

    Returns:
        (count, 4) lowest x and y, highest x and y; infinite the wrong way round where a label has
        none.
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
