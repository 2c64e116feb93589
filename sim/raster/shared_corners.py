"""Triangles of moving bodies whose shared corners are moved and projected only once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined
from sim.geometry.pinhole import Projection
from sim.raster.scan_conversion import clip_triangle, transform_points
from sim.raster.triangles import TriangleSoup

F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]


class SharedCorners(NamedTuple):
    """The corners of a triangle soup, each once.

    Attributes:
        corners_m: (n, 3) float64 positions in the frames of their bodies [m].
        body: (n,) int32 number of the body that each corner belongs to.
        faces: (m, 3) int32 corners of each triangle, in the order of the soup.
    """

    corners_m: F64
    body: I32
    faces: I32


def share_corners(soup: TriangleSoup) -> SharedCorners:
    """Return the corners of a soup, of which equal ones of a body are merged."""
    corners = np.column_stack([soup.triangles_m.reshape(-1, 3), np.repeat(soup.body, 3)])
    unique, faces = np.unique(corners, axis=0, return_inverse=True)
    return SharedCorners(
        np.ascontiguousarray(unique[:, :3]),
        unique[:, 3].astype(np.int32),
        faces.reshape(-1, 3).astype(np.int32),
    )


@compiled
def project_bodies(
    shared: SharedCorners, labels: I32, views: F64, projection: Projection, near: float
) -> tuple[F64, I32]:
    """Move the triangles of bodies, and project those that face the camera.

    Args:
        shared: corners of the triangles.
        labels: (m,) label of each triangle.
        views: (bodies, 3, 4) transform from each body's frame to the camera's.
        projection: projection of the camera onto the grid [grid points].
        near: distance of the near plane [m].

    Returns:
        Triangles as from `project_faces`, and the label of each.
    """
    in_camera = transform_points(shared.corners_m, shared.body, views)
    focal, centre_x, centre_y = projection
    projected, source = project_faces(in_camera, shared.faces, focal, centre_x, centre_y, near)
    return projected, labels[source]


@compiled
def project_faces(
    corners: F64, faces: I32, focal: float, centre_x: float, centre_y: float, near: float
) -> tuple[F64, I32]:
    """Project the triangles that face the camera, and clip them at the near plane.

    Args:
        corners: (n, 3) corners in the camera's frame: right, down, forward [m].
        faces: (m, 3) corners of each triangle.
        focal: focal length [grid points].
        centre_x: column where the optical axis meets the grid [grid points].
        centre_y: row where the optical axis meets the grid [grid points].
        near: distance of the near plane [m].

    Returns:
        (m, 3, 3) x, y [grid points] and 1/depth [1/m] of each corner; and (m,) the index of the
        triangle that each comes from.
    """
    projected, clipped, cut = np.empty_like(corners), np.empty((4, 3)), np.empty((1, 3, 3))
    for k in range(len(corners)):
        _project(corners[k], focal, centre_x, centre_y, projected[k])
    out, source = np.empty((2 * len(faces), 3, 3)), np.empty(2 * len(faces), np.int32)
    count = 0
    for t in range(len(faces)):
        inside = 0
        for i in range(3):
            inside += corners[faces[t, i], 2] >= near
        if inside == 3:
            a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
            if not faces_camera(projected[a], projected[b], projected[c]):
                continue
            for axis in range(3):
                out[count, 0, axis] = projected[a, axis]
                out[count, 1, axis] = projected[b, axis]
                out[count, 2, axis] = projected[c, axis]
            source[count] = t
            count += 1
        elif inside > 0:
            for i in range(3):
                cut[0, i] = corners[faces[t, i]]
            size = clip_triangle(cut, 0, near, clipped)
            for fan in range(size - 2):
                for i in range(3):
                    k = 0 if i == 0 else fan + i
                    _project(clipped[k], focal, centre_x, centre_y, out[count, i])
                source[count] = t
                count += faces_camera(out[count, 0], out[count, 1], out[count, 2])
    return out[:count], source[:count]


@inlined
def faces_camera(a: F64, b: F64, c: F64) -> bool:
    """Return True if the corners of a triangle, x to the right and y down, are anticlockwise."""
    area = float((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
    return area < 0.0


@inlined
def _project(corner: F64, focal: float, centre_x: float, centre_y: float, out: F64) -> None:
    """Set x, y [grid points] and 1/depth [1/m] of a corner in the camera's frame."""
    nearness = 1.0 / corner[2]
    out[0] = centre_x + focal * corner[0] * nearness
    out[1] = centre_y + focal * corner[1] * nearness
    out[2] = nearness
