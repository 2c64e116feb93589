"""What each pixel's middle shows, and how far away: exact, from poses and triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import NEAR_M, Intrinsics, Pose
from sim.geometry.rectangles import Rectangle
from sim.geometry.rigid_transform import compose_transforms
from sim.raster.scan_conversion import NOTHING, empty_buffer, perspective, rasterise
from sim.raster.triangles import Soup

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Visible:
    """What each pixel's middle shows.

    Attributes:
        body: (height, width) int32, number of the rigid body; 0 for what is fixed to the world,
            -1 for the sky.
        nearness: (height, width) float32, 1/depth along the optical axis [1/m]; 0 for the sky.
    """

    body: I32
    nearness: F32


def look(
    soup: Soup, poses: F64, pose: Pose, lens: Intrinsics, before: Visible | None = None
) -> Visible:
    """Look at triangles from a camera.

    Args:
        soup: the triangles.
        poses: (bodies, 3, 4) from each body's frame into the world.
        pose: the camera's.
        lens: likewise.
        before: what else the same camera sees; it stays as it is.
    """
    if before is None:
        nearness, body = empty_buffer(lens.height, lens.width)
    else:
        nearness, body = before.nearness.copy(), before.body.copy()
    seen = soup.moved(compose_transforms(poses, pose.into))
    flat, source = perspective(seen, lens.focal_px, lens.width / 2, lens.height / 2, NEAR_M)
    rasterise(flat, soup.body[source], 0, 0, nearness, body, True)
    return Visible(body, nearness)


def show_middles(
    visible: Visible, label: I32, nearness: F32, rectangle: Rectangle, supersample: int
) -> None:
    """Put movers over what is visible, in place.

    Args:
        visible: without them.
        label: fine points of the rectangle: which body is seen, `NOTHING` for what was there.
        nearness: of the same points [1/m].
        rectangle: x0, y0, x1, y1 [px].
        supersample: points per pixel and axis; if even, the point after the middle is taken.
    """
    x0, y0, x1, y1 = rectangle
    middle = slice(supersample // 2, None, supersample)
    body = label[middle, middle]
    moved = body != NOTHING
    visible.body[y0:y1, x0:x1][moved] = body[moved]
    visible.nearness[y0:y1, x0:x1][moved] = nearness[middle, middle][moved]
