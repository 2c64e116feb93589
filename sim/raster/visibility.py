"""Body and nearness at every pixel centre, computed exactly from poses and triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import NEAR_M, Intrinsics, Pose
from sim.geometry.rigid_transform import compose_transforms
from sim.raster.scan_conversion import empty_buffer, project_triangles, rasterise
from sim.raster.triangles import Triangles, TriangleSoup

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class VisibilityMap:
    """Body and nearness at every pixel centre.

    Attributes:
        body: (height, width) int32, number of the rigid body; 0 for what is fixed to the world,
            -1 for the sky. `PhotometricCamera.visible` adds numbers for what deforms.
        nearness: (height, width) float32, 1/depth along the optical axis [1/m]; 0 for the sky.
    """

    body: I32
    nearness: F32


def visibility_map(
    soup: TriangleSoup,
    poses: F64,
    pose: Pose,
    lens: Intrinsics,
    before: VisibilityMap | None = None,
) -> VisibilityMap:
    """Return what a camera sees of a triangle soup at its pixel centres.

    Args:
        soup: triangles to look at.
        poses: (bodies, 3, 4) transform from each body's frame into the world.
        pose: pose of the camera.
        lens: intrinsics of the camera.
        before: other things that the camera sees; they hide triangles behind them. Not changed.
    """
    if before is None:
        nearness, body = empty_buffer(lens.height, lens.width)
    else:
        nearness, body = before.nearness.copy(), before.body.copy()
    view = lens.stretched(pose.world_to_camera)
    in_camera = soup.transformed(compose_transforms(poses, view))
    projected, source = project_triangles(in_camera, lens.focal_px, *lens.centre_px, NEAR_M)
    rasterise(projected, soup.body[source], 0, 0, nearness, body, True)
    return VisibilityMap(body, nearness)


def overlay_triangles(
    visible: VisibilityMap, triangles_m: Triangles, first: int, pose: Pose, lens: Intrinsics
) -> None:
    """Write single triangles over a visibility map, in place.

    Args:
        visible: map of everything else.
        triangles_m: (n, 3, 3) triangles in the world [m].
        first: number to write for the first triangle; the others follow.
        pose: pose of the camera.
        lens: intrinsics of the camera.
    """
    view = lens.stretched(pose.world_to_camera)
    in_camera = np.asarray(triangles_m @ view[:, :3].T + view[:, 3])
    projected, source = project_triangles(in_camera, lens.focal_px, *lens.centre_px, NEAR_M)
    label = (first + source).astype(np.int32)
    rasterise(projected, label, 0, 0, visible.nearness, visible.body, True)
