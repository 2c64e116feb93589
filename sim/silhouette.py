"""How much of the image an object would take up alone, beyond the image's border too."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from numba import njit

from sim.camera import Intrinsics
from sim.renderer import NEAR_M
from sim.triangles import Soup

F64 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int8]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]

POINTS = 2_000
"""About how many pixels, evenly spread, stand for the box around a silhouette: of one that is half
full, that counts the share that is seen to about 1 % (assumed)."""


class Silhouette:
    """An object's triangles, ready to be counted pixel by pixel as often as it moves."""

    def __init__(self, soup: Soup) -> None:
        """Prepare.

        Args:
            soup: the object's triangles.
        """
        corners = np.column_stack([soup.triangles_m.reshape(-1, 3), np.repeat(soup.body, 3)])
        unique, faces = np.unique(corners, axis=0, return_inverse=True)
        self._corners_m = np.ascontiguousarray(unique[:, :3])
        self._body = unique[:, 3].astype(np.int32)
        self._faces = faces.reshape(-1, 3).astype(np.int32)

    def visibility(self, views: F64, lens: Intrinsics, labels: I8, number: int) -> float:
        """Share of the silhouette's pixels that the image shows.

        Args:
            views: (bodies, 3, 4) from each body's frame into the camera's.
            lens: the camera's.
            labels: (height, width) what each pixel's middle shows.
            number: what is the object's there.

        Returns:
            0 to 1: 1 where nothing stands before the object and all of it is in the image.
        """
        middle = lens.width / 2, lens.height / 2
        flat, span = _projected(self._corners_m, self._body, views, lens.focal_px, *middle, NEAR_M)
        low, high = np.floor(span[0]), np.ceil(span[1])
        if not ((high > 0) & (low < [lens.width, lens.height])).all():
            return 0.0
        stride = max(math.isqrt(int(np.prod(high - low) / POINTS)), 1)
        columns, rows = (int(n) for n in -(-(high - low) // stride))
        covered = np.zeros((rows, columns), np.bool_)
        # Grid point (i, j) is the middle of pixel (x0 + i · stride, y0 + j · stride).
        _cover((flat - (low + 0.5)) / stride + 0.5, self._faces, covered)
        alone = int(np.count_nonzero(covered))
        x, y = (int(n) % stride if n < 0 else int(n) for n in low)
        seen = labels[y : int(high[1]) : stride, x : int(high[0]) : stride] == number
        return min(int(np.count_nonzero(seen)) / alone, 1.0) if alone else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _projected(
    corners: F64,
    body: I32,
    views: F64,
    focal: float,
    centre_x: float,
    centre_y: float,
    near: float,
) -> tuple[F64, F64]:
    """Image coordinates of corners.

    Args:
        corners: (n, 3) in their bodies' frames [m].
        body: (n,) which body each belongs to.
        views: (bodies, 3, 4) from there into the camera's frame.
        focal: of the camera [px].
        centre_x: where its axis meets the image [px].
        centre_y: likewise.
        near: how near corners may be to the camera [m].

    Returns:
        (n, 2) coordinates, not a number where nearer; and (2, 2) the lowest and highest of them,
        infinite the wrong way round where there are none.
    """
    flat = np.full((len(corners), 2), np.nan)
    low_x = low_y = math.inf
    high_x = high_y = -math.inf
    for k in range(len(corners)):
        a, b, c, i = corners[k, 0], corners[k, 1], corners[k, 2], body[k]
        z = views[i, 2, 0] * a + views[i, 2, 1] * b + views[i, 2, 2] * c + views[i, 2, 3]
        if z < near:
            continue
        x = views[i, 0, 0] * a + views[i, 0, 1] * b + views[i, 0, 2] * c + views[i, 0, 3]
        y = views[i, 1, 0] * a + views[i, 1, 1] * b + views[i, 1, 2] * c + views[i, 1, 3]
        x, y = centre_x + focal * x / z, centre_y + focal * y / z
        flat[k, 0], flat[k, 1] = x, y
        low_x, low_y = min(low_x, x), min(low_y, y)
        high_x, high_y = max(high_x, x), max(high_y, y)
    return flat, np.array([[low_x, low_y], [high_x, high_y]])


@njit(cache=True, nogil=True, error_model="numpy")
def _cover(flat: F64, faces: I32, covered: Bools) -> None:
    """Mark the grid points inside of triangles that face the camera; (i, j) is at (i + ½, j + ½).

    Args:
        flat: (n, 2) corners [grid points]; triangles with one that is not a number are left out.
        faces: (m, 3) triangles, anticlockwise as seen from outside.
        covered: (height, width), set to true in place.
    """
    height, width = covered.shape
    for k in range(len(faces)):
        a, b, c = faces[k, 0], faces[k, 1], faces[k, 2]
        ax, ay, bx, by = flat[a, 0], flat[a, 1], flat[b, 0], flat[b, 1]
        cx, cy = flat[c, 0], flat[c, 1]
        if not (bx - ax) * (cy - ay) - (cx - ax) * (by - ay) < 0.0:
            continue
        first = max(math.ceil(min(ay, by, cy) - 0.5), 0)
        last = min(math.ceil(max(ay, by, cy) - 0.5), height)
        for row in range(first, last):
            y = row + 0.5
            low, high = math.inf, -math.inf
            for edge in range(3):
                if edge == 0:
                    ux, uy, vx, vy = ax, ay, bx, by
                elif edge == 1:
                    ux, uy, vx, vy = bx, by, cx, cy
                else:
                    ux, uy, vx, vy = cx, cy, ax, ay
                if (uy <= y) != (vy <= y):
                    if vy < uy:  # as `sim.raster` does
                        ux, uy, vx, vy = vx, vy, ux, uy
                    x = ux + (vx - ux) * (y - uy) / (vy - uy)
                    low, high = min(low, x), max(high, x)
            start = max(math.ceil(low - 0.5), 0)
            for column in range(start, min(math.ceil(high - 0.5), width)):
                covered[row, column] = True
