"""Fraction of a moving object that the image shows.

The whole silhouette is counted as if the object were alone, including the part beyond the image's
border.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import NEAR_M, Intrinsics, Projection
from sim.raster.scan_conversion import mark_covered
from sim.raster.shared_corners import share_corners
from sim.raster.triangles import TriangleSoup

F64 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int8]
I32 = npt.NDArray[np.int32]

SAMPLED_PIXELS = 2_000
"""Approximate number of pixels, evenly spread, that are sampled in the bounding box of a
silhouette. If the silhouette fills half of the box, this gives the visible fraction to about 1 %
(assumed)."""


class VisibleFraction:
    """An object's triangles, prepared for measuring its visible fraction at many times."""

    def __init__(self, soup: TriangleSoup) -> None:
        """Prepare the triangles of an object."""
        self._shared = share_corners(soup)

    def measure(self, views: F64, lens: Intrinsics, labels: I8, number: int) -> float:
        """Return the fraction of the silhouette's pixels that the image shows.

        Args:
            views: (bodies, 3, 4) transform from each body's frame into the camera's.
            lens: intrinsics of the camera.
            labels: (height, width) number of the object at each pixel centre.
            number: number of this object in `labels`.

        Returns:
            0 to 1; 1 if the object is entirely in the image and nothing occludes it.
        """
        shared = self._shared
        projection = Projection(lens.focal_px, lens.width / 2, lens.height / 2)
        corners_px, *span = _project(shared.corners_m, shared.body, views, projection)
        if not (span[0] < lens.width and span[1] < lens.height and span[2] > 0 and span[3] > 0):
            return 0.0
        x0, y0 = math.floor(span[0]), math.floor(span[1])
        x1, y1 = math.ceil(span[2]), math.ceil(span[3])
        stride = max(math.isqrt((x1 - x0) * (y1 - y0) // SAMPLED_PIXELS), 1)
        grid = np.zeros((-(-(y1 - y0) // stride), -(-(x1 - x0) // stride)), np.bool_)
        whole = mark_covered(corners_px, shared.faces, x0 + 0.5, y0 + 0.5, float(stride), grid)
        x, y = (n % stride if n < 0 else n for n in (x0, y0))
        visible = int(np.count_nonzero(labels[y:y1:stride, x:x1:stride] == number))
        return min(visible / whole, 1.0) if whole else 0.0


@compiled
def _project(
    corners: F64, body: I32, views: F64, projection: Projection
) -> tuple[F64, float, float, float, float]:
    """Project corners into the image.

    Args:
        corners: (n, 3) positions in their bodies' frames [m].
        body: (n,) number of the body that each corner belongs to.
        views: (bodies, 3, 4) transform from each body's frame into the camera's.
        projection: projection of the camera.

    Returns:
        (n, 2) image coordinates [px], NaN for corners nearer than the near plane; and lowest x,
        lowest y, highest x, highest y. If there are none, the lowest are +∞ and the highest −∞.
    """
    focal, centre_x, centre_y = projection
    corners_px = np.full((len(corners), 2), np.nan)
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
        corners_px[k, 0], corners_px[k, 1] = x, y
        low_x, low_y = min(low_x, x), min(low_y, y)
        high_x, high_y = max(high_x, x), max(high_y, y)
    return corners_px, low_x, low_y, high_x, high_y
