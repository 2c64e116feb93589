"""The image of a camera that has turned, from a finer one of a camera at rest in the same place.

Nothing is interpolated: each pixel weighs the fine points around the place that it looks at with
its aperture, wherever these lie in it. A bright edge's faint skirt, which the logarithm of a dark
pixel beside it feels, stays what it is.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Intrinsics, Pose
from sim.raster.aperture import LENS_BLUR_PX, REACH_PX

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

TABLE = 256
"""Places a pixel at which the aperture is tabulated; the nearest is taken (assumed)."""


def rotated_image(
    image: F32,
    rest: Pose,
    wide: Intrinsics,
    turned: Pose,
    lens: Intrinsics,
    blur_px: float = LENS_BLUR_PX,
) -> F32:
    """What a turned camera's pixels see; a rotation maps rays to rays, whatever their depth.

    Args:
        image: (wide.height, wide.width) float32 points, of the camera at rest; its border goes on
            outside.
        rest: its pose.
        wide: its lens, of a focal length some whole number of times `lens`'s.
        turned: the pose wanted, in the same place.
        lens: the lens wanted.
        blur_px: deviation of its point spread [px of `lens`].

    Returns:
        (lens.height, lens.width) float32.
    """
    rotation = rest.into[:, :3] @ turned.into[:, :3].T
    back = _grid(wide) @ rotation @ np.linalg.inv(_grid(lens))
    scale = wide.focal_px / lens.focal_px
    out = np.empty((lens.height, lens.width), np.float32)
    _gather(image, back, scale, aperture_table(blur_px), out)
    return out


def aperture_table(blur_px: float) -> F64:
    """A pixel's aperture along an axis: its width, blurred by the lens, cut off as in `aperture`.

    Returns:
        (n,) float64 at distances of 0, 1 / `TABLE` and so on from its middle, to its end [px].
    """
    reach = 0.5 + REACH_PX
    distance = np.arange(math.ceil(reach * TABLE)) / TABLE
    deviation = max(blur_px, 1e-3) * math.sqrt(2)
    ends = [math.erf((x + side) / deviation) for side in (0.5, -0.5) for x in distance]
    table: F64 = np.subtract(ends[: len(distance)], ends[len(distance) :])
    return table


@compiled
def _gather(image: F32, back: F64, scale: float, table: F64, out: F32) -> None:
    """Weigh the fine points around each pixel's place.

    Args:
        image: (rows, columns) fine points.
        back: (3, 3) from pixels to fine points, homogeneous; the first point's middle is at ½, ½.
        scale: fine points per pixel.
        table: as `aperture_table` gives it.
        out: (height, width), filled.
    """
    rows, columns = image.shape
    reach = len(table) / TABLE * scale
    most = 2 * math.ceil(reach) + 1
    across = np.empty(most, np.float32)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            x, y = j + 0.5, i + 0.5
            w = back[2, 0] * x + back[2, 1] * y + back[2, 2]
            u = (back[0, 0] * x + back[0, 1] * y + back[0, 2]) / w
            v = (back[1, 0] * x + back[1, 1] * y + back[1, 2]) / w
            left, top = math.ceil(u - reach - 0.5), math.ceil(v - reach - 0.5)
            wide = 0
            whole = np.float32(0.0)
            for k in range(most):
                place = int(abs(left + k + 0.5 - u) / scale * TABLE + 0.5)
                across[k] = table[place] if place < len(table) else 0.0
                whole += across[k]
                wide = k + 1 if across[k] > 0.0 else wide
            total = weight = np.float32(0.0)
            inside = left >= 0 and left + wide <= columns
            for k in range(most):
                place = int(abs(top + k + 0.5 - v) / scale * TABLE + 0.5)
                if place >= len(table):
                    continue
                down = np.float32(table[place])
                row = min(max(top + k, 0), rows - 1)
                line = np.float32(0.0)
                if inside:
                    for m in range(wide):
                        line += across[m] * image[row, left + m]
                else:
                    for m in range(wide):
                        line += across[m] * image[row, min(max(left + m, 0), columns - 1)]
                total += down * line
                weight += down * whole
            out[i, j] = total / weight


def _grid(lens: Intrinsics) -> F64:
    """(3, 3) from a camera's frame to its grid, on which the image's corner is 0, 0."""
    return np.array(
        [
            [lens.focal_px, 0, lens.width / 2],
            [0, lens.focal_px, lens.height / 2],
            [0, 0, 1],
        ]
    )
