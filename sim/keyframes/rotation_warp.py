"""Image of a rotated camera, computed from a wider and finer image of a steady camera.

Nothing is interpolated. Each pixel is the mean of the steady image's pixels (here called
sub-pixels) around the point that it looks at, weighted with its aperture at their exact distances.
This preserves the faint halo of a bright edge. It matters because a dark pixel beside the edge
responds to the logarithm of its luminance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Intrinsics, Pose
from sim.raster.aperture import BLUR_REACH_PX, LENS_BLUR_PX
from sim.scene.scene import Scene

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

SHAKE_MARGIN_PX = 3
"""Margin beyond the largest displacement by shake, for the pixel's aperture (assumed)."""
SHAKE_SCALE = 3
"""Pixels of the steady camera per pixel of the shaking camera, along each axis: as many as the
default supersampling gives a steady camera."""
TABLE_STEPS = 256
"""Steps per pixel at which the aperture is tabulated; the nearest is used (assumed)."""


def steady_lens(scene: Scene, lens: Intrinsics, times_s: Sequence[float]) -> Intrinsics:
    """Return a lens for a steady camera that sees everything the shaking camera sees, but finer.

    Args:
        scene: scene with or without camera shake.
        lens: intrinsics of the shaking camera.
        times_s: sample times [s].

    Returns:
        The wider and finer lens; `lens` itself if the scene has no shake.
    """
    if scene.shake is None:
        return lens
    angle = max(float(np.linalg.norm(scene.shake.rotation_rad(t))) for t in times_s)
    corner = math.hypot(lens.width, lens.height) / 2 / lens.focal_px
    swing = math.tan(math.atan(corner) + angle) - corner
    margin_px = math.ceil(lens.focal_px * swing) + SHAKE_MARGIN_PX
    return lens.with_margin(margin_px).scaled(SHAKE_SCALE)


def rotated_image(
    image: F32,
    steady_pose: Pose,
    steady_lens: Intrinsics,
    pose: Pose,
    lens: Intrinsics,
    blur_px: float = LENS_BLUR_PX,
) -> F32:
    """Return the image of a rotated camera.

    A rotation maps rays to rays, whatever their depth.

    Args:
        image: (steady_lens.height, steady_lens.width) float32 image of the steady camera. Its
            border values continue outside it.
        steady_pose: pose of the steady camera.
        steady_lens: intrinsics of the steady camera. Its focal length is a whole multiple of that
            of `lens`.
        pose: pose of the rotated camera, in the same position.
        lens: intrinsics of the rotated camera.
        blur_px: standard deviation of the point spread of `lens` [px of `lens`].

    Returns:
        (lens.height, lens.width) float32.
    """
    rotation = steady_pose.world_to_camera[:, :3] @ pose.world_to_camera[:, :3].T
    back = _camera_matrix(steady_lens) @ rotation @ np.linalg.inv(_camera_matrix(lens))
    scale = steady_lens.focal_px / lens.focal_px
    out = np.empty((lens.height, lens.width), np.float32)
    _gather(image, back, scale, aperture_table(blur_px), out)
    return out


def aperture_table(blur_px: float) -> F64:
    """Return a pixel's aperture along an axis: its width, blurred by the lens.

    The blur is cut off as in `sim.raster.aperture`.

    Args:
        blur_px: standard deviation of the lens's point spread [px].

    Returns:
        (n,) float64 at distances of 0, 1 / `TABLE_STEPS`, … [px] from the pixel centre to the
        aperture's end.
    """
    reach = 0.5 + BLUR_REACH_PX
    distance = np.arange(math.ceil(reach * TABLE_STEPS)) / TABLE_STEPS
    deviation = max(blur_px, 1e-3) * math.sqrt(2)
    ends = [math.erf((x + side) / deviation) for side in (0.5, -0.5) for x in distance]
    table: F64 = np.subtract(ends[: len(distance)], ends[len(distance) :])
    return table


@compiled
def _gather(image: F32, back: F64, scale: float, table: F64, out: F32) -> None:
    """Set each pixel to the weighted mean of the sub-pixels in its aperture.

    Args:
        image: (rows, columns) sub-pixels.
        back: (3, 3) homogeneous map from pixel to sub-pixel coordinates. The centre of the first
            sub-pixel is at (½, ½).
        scale: sub-pixels per pixel and axis.
        table: aperture, from `aperture_table`.
        out: (height, width), overwritten.
    """
    rows, columns = image.shape
    reach = len(table) / TABLE_STEPS * scale
    max_count = 2 * math.ceil(reach) + 1
    across = np.empty(max_count, np.float32)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            x, y = j + 0.5, i + 0.5
            w = back[2, 0] * x + back[2, 1] * y + back[2, 2]
            u = (back[0, 0] * x + back[0, 1] * y + back[0, 2]) / w
            v = (back[1, 0] * x + back[1, 1] * y + back[1, 2]) / w
            left, top = math.ceil(u - reach - 0.5), math.ceil(v - reach - 0.5)
            count = 0
            row_weight = np.float32(0.0)
            for k in range(max_count):
                step = int(abs(left + k + 0.5 - u) / scale * TABLE_STEPS + 0.5)
                across[k] = table[step] if step < len(table) else 0.0
                row_weight += across[k]
                count = k + 1 if across[k] > 0.0 else count
            total = weight = np.float32(0.0)
            inside = left >= 0 and left + count <= columns
            for k in range(max_count):
                step = int(abs(top + k + 0.5 - v) / scale * TABLE_STEPS + 0.5)
                if step >= len(table):
                    continue
                down = np.float32(table[step])
                row = min(max(top + k, 0), rows - 1)
                line = np.float32(0.0)
                if inside:
                    for m in range(count):
                        line += across[m] * image[row, left + m]
                else:
                    for m in range(count):
                        line += across[m] * image[row, min(max(left + m, 0), columns - 1)]
                total += down * line
                weight += down * row_weight
            out[i, j] = total / weight


def _camera_matrix(lens: Intrinsics) -> F64:
    """Return the (3, 3) map from the camera's frame to pixels; the image's corner is (0, 0)."""
    return np.array(
        [
            [lens.focal_px, 0, lens.width / 2],
            [0, lens.focal_px, lens.height / 2],
            [0, 0, 1],
        ]
    )
