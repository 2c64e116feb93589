"""How much of the image an object would take up alone, beyond the image's border too."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import NEAR_M, Intrinsics
from sim.raster.scan_conversion import cover
from sim.raster.triangles import Soup

F64 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int8]
I32 = npt.NDArray[np.int32]

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
        flat, *span = _projected(
            self._corners_m, self._body, views, lens.focal_px, lens.width / 2, lens.height / 2
        )
        if not (span[0] < lens.width and span[1] < lens.height and span[2] > 0 and span[3] > 0):
            return 0.0
        x0, y0 = math.floor(span[0]), math.floor(span[1])
        x1, y1 = math.ceil(span[2]), math.ceil(span[3])
        stride = max(math.isqrt((x1 - x0) * (y1 - y0) // POINTS), 1)
        grid = np.zeros((-(-(y1 - y0) // stride), -(-(x1 - x0) // stride)), np.bool_)
        alone = cover(flat, self._faces, x0 + 0.5, y0 + 0.5, float(stride), grid)
        x, y = (n % stride if n < 0 else n for n in (x0, y0))
        seen = int(np.count_nonzero(labels[y:y1:stride, x:x1:stride] == number))
        return min(seen / alone, 1.0) if alone else 0.0


@compiled
def _projected(
    corners: F64,
    body: I32,
    views: F64,
    focal: float,
    centre_x: float,
    centre_y: float,
) -> tuple[F64, float, float, float, float]:
    """Image coordinates of corners.

    Args:
        corners: (n, 3) in their bodies' frames [m].
        body: (n,) which body each belongs to.
        views: (bodies, 3, 4) from there into the camera's frame.
        focal: of the camera [px].
        centre_x: where its axis meets the image [px].
        centre_y: likewise.

    Returns:
        (n, 2) coordinates, not a number before the near plane; and the lowest x and y and the
        highest, infinite the wrong way round where there are none.
    """
    flat = np.full((len(corners), 2), np.nan)
    low_x = low_y = math.inf
    high_x = high_y = -math.inf
    for k in range(len(corners)):
        a, b, c, i = corners[k, 0], corners[k, 1], corners[k, 2], body[k]
        z = views[i, 2, 0] * a + views[i, 2, 1] * b + views[i, 2, 2] * c + views[i, 2, 3]
        if z < NEAR_M:
            continue
        x = views[i, 0, 0] * a + views[i, 0, 1] * b + views[i, 0, 2] * c + views[i, 0, 3]
        y = views[i, 1, 0] * a + views[i, 1, 1] * b + views[i, 1, 2] * c + views[i, 1, 3]
        x, y = centre_x + focal * x / z, centre_y + focal * y / z
        flat[k, 0], flat[k, 1] = x, y
        low_x, low_y = min(low_x, x), min(low_y, y)
        high_x, high_y = max(high_x, x), max(high_y, y)
    return flat, low_x, low_y, high_x, high_y
