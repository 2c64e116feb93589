"""Shadow maps: the nearness of a moving object to a light, for each direction.

Each pair of a light and a moving object has its own map. It is computed again at every sample,
because the shadow changes as the object moves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.rigid_transform import axes_along, chain
from sim.raster.scan_conversion import rasterise, transform_points
from sim.raster.shared_corners import SharedCorners, faces_camera, project_faces
from sim.scene.moving_objects import MovingObject

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]

MAP_SIDE = 512
"""Maximum rows and columns of a map (assumed; enough for a van's shadow in texels of `TEXEL_M`)."""
TEXEL_M = 0.025
"""Side of a map's texel on the ground, unless `MAP_SIDE` demands larger texels; about what a pixel
sees at the vehicle's distance (assumed)."""
LAMP_NEAR_M = 0.1
"""Minimum distance of objects from a lamp (assumed)."""
NO_CASTER = np.float32(-np.inf)
"""Nearness of a texel in which no object is in front of the light."""


@dataclass(frozen=True, eq=False)
class ShadowSource:
    """A light that casts shadows: the sun or a lamp.

    Attributes:
        axes: (3, 3) rows: the map's right and down, and the direction away from the light.
        position_m: (3,) position of the lamp; arbitrary for the sun.
        is_sun: True for the sun, whose rays are parallel.
    """

    axes: F64
    position_m: F64
    is_sun: bool


def shadow_sources(model: mujoco.MjModel, data: mujoco.MjData, lights: I64) -> list[ShadowSource]:
    """Return the lights with these numbers, which are suns or spot lights."""
    return [
        ShadowSource(
            axes_along(data.light_xdir[k]),
            data.light_xpos[k].copy(),
            bool(model.light_type[k] == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL),
        )
        for k in lights
    ]


@dataclass(frozen=True, eq=False)
class ShadowMap:
    """Geometry of the shadow map of one object and one light.

    Attributes:
        view: (3, 4) map from the world to column, row and nearness; homogeneous for a lamp.
        size: rows and columns in use.
    """

    view: F64
    size: tuple[int, int]


def render_shadow_map(
    source: ShadowSource,
    obj: MovingObject,
    caster: SharedCorners,
    poses: F64,
    out: F32,
) -> ShadowMap | None:
    """Render how near an object is to a light.

    Args:
        source: the light.
        obj: the object in front of the light.
        caster: triangles of the object that cast shadows.
        poses: (bodies, 3, 4) transform from each body's frame into the world.
        out: (`MAP_SIDE`, `MAP_SIDE`) float32; the map is written to its upper left part.

    Returns:
        Geometry of the map; None if the object casts no shadow or is entirely behind the lamp.
    """
    if not len(caster.faces):
        return None
    origin_m = poses[obj.root, :, 3].copy() if source.is_sun else source.position_m
    corners = caster.corners_m, caster.body, caster.faces
    view, rows, columns = _rasterise_map(source.axes, origin_m, source.is_sun, *corners, poses, out)
    return ShadowMap(view, (rows, columns)) if rows else None


@compiled
def _rasterise_map(
    axes: F64,
    origin_m: F64,
    is_sun: bool,
    corners_m: F64,
    body: I32,
    faces: I32,
    poses: F64,
    out: F32,
) -> tuple[F64, int, int]:
    """Rasterise a shadow map.

    Args:
        axes: (3, 3) axes of the light; see `ShadowSource`.
        origin_m: (3,) origin of the light's frame.
        is_sun: True for the sun.
        corners_m: (n, 3) corners of the caster in the frames of their bodies [m].
        body: (n,) number of the body that each corner belongs to.
        faces: (m, 3) corners of each triangle.
        poses: (bodies, 3, 4) transform from each body's frame into the world.
        out: the map is written to its upper left part.

    Returns:
        View of the map, see `ShadowMap`, and rows and columns in use; no rows if all is behind the
        lamp.
    """
    view, to_light = np.empty((3, 4)), np.empty_like(poses)
    for axis in range(3):
        view[axis, :3], view[axis, 3] = axes[axis], -np.dot(axes[axis], origin_m)
    for k in range(len(poses)):
        chain(poses[k], view, to_light[k])
    corners = transform_points(corners_m, body, to_light)
    if is_sun:
        texel, triangles, count = TEXEL_M, np.empty((len(faces), 3, 3)), 0
        for t in range(len(faces)):
            a, b, c = corners[faces[t, 0]], corners[faces[t, 1]], corners[faces[t, 2]]
            if faces_camera(a, b, c):
                triangles[count, 0], triangles[count, 1], triangles[count, 2] = a, b, c
                count += 1
        triangles = triangles[:count]
        triangles[:, :, 2] *= -1.0
    else:
        farthest_m = corners[:, 2].max()
        if farthest_m < LAMP_NEAR_M:
            return view, 0, 0
        texel = TEXEL_M / farthest_m
        triangles, _ = project_faces(corners, faces, 1.0, 0.0, 0.0, LAMP_NEAR_M)
    if not len(triangles):
        return view, 0, 0
    low_x, high_x = triangles[:, :, 0].min(), triangles[:, :, 0].max()
    low_y, high_y = triangles[:, :, 1].min(), triangles[:, :, 1].max()
    texel = max(texel, max(high_x - low_x, high_y - low_y) / (MAP_SIDE - 7))
    left, top = math.floor(low_x / texel) - 2.0, math.floor(low_y / texel) - 2.0
    columns = int(math.ceil(high_x / texel) - left + 3)
    rows = int(math.ceil(high_y / texel) - top + 3)
    for t in range(len(triangles)):
        for i in range(3):
            triangles[t, i, 0] = triangles[t, i, 0] / texel - left
            triangles[t, i, 1] = triangles[t, i, 1] / texel - top
    used = out[:rows, :columns]
    used[:] = NO_CASTER
    no_label = np.empty((0, 0), np.int32)
    rasterise(triangles, np.empty(len(triangles), np.int32), 0, 0, used, no_label, True)
    view[:2] /= texel
    if is_sun:
        view[0, 3] -= left
        view[1, 3] -= top
        view[2] *= -1.0
    else:
        view[0] -= left * view[2]
        view[1] -= top * view[2]
    return view, rows, columns
