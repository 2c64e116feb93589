"""Shadow maps: the nearness of a moving object to a light, for each direction.

Each pair of a light and a moving object has its own map. It is computed again at every sample,
because the shadow changes as the object moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.rigid_transform import axes_along, compose_transforms, world_to_frame
from sim.raster.scan_conversion import project_triangles, rasterise
from sim.raster.triangles import TriangleSoup
from sim.scene.moving_objects import MovingObject

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
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
    soup: TriangleSoup,
    data: mujoco.MjData,
    poses: F64,
    out: F32,
) -> ShadowMap | None:
    """Render how near an object is to a light.

    Args:
        source: the light.
        obj: the object in front of the light.
        soup: triangles of the object that cast shadows.
        data: positions of the object's bodies.
        poses: (bodies, 3, 4) transform from each body's frame into the world.
        out: (`MAP_SIDE`, `MAP_SIDE`) float32; the map is written to its upper left part.

    Returns:
        Geometry of the map; None if the object casts no shadow or is entirely behind the lamp.
    """
    origin_m = data.xpos[obj.root] if source.is_sun else source.position_m
    to_light = world_to_frame(source.axes, origin_m)
    triangles = soup.transformed(compose_transforms(poses, to_light))
    if not len(triangles):
        return None
    if source.is_sun:
        texel = TEXEL_M
        triangles[..., 2] *= -1
    else:
        farthest_m = _span(triangles)[1, 2]
        if farthest_m < LAMP_NEAR_M:
            return None
        texel = TEXEL_M / farthest_m
        triangles, _ = project_triangles(triangles, 1.0, 0.0, 0.0, LAMP_NEAR_M)
    low, high = _span(triangles)[:, :2]
    texel = max(texel, float((high - low).max()) / (MAP_SIDE - 7))
    start = np.floor(low / texel) - 2
    columns, rows = (int(n) for n in np.ceil(high / texel) - start + 3)
    _to_texels(triangles, texel, start)
    used = out[:rows, :columns]
    used.fill(NO_CASTER)
    labels, unused = np.zeros(len(triangles), np.int32), np.empty(used.shape, np.int32)
    rasterise(triangles, labels, 0, 0, used, unused, True)
    last = -to_light[2:] if source.is_sun else to_light[2:]
    shift = np.outer(start, [0, 0, 0, 1] if source.is_sun else to_light[2])
    return ShadowMap(np.concatenate([to_light[:2] / texel - shift, last]), (rows, columns))


@compiled
def _span(triangles: F64) -> F64:
    """Return the lowest and highest coordinates of (n, 3, 3) corners along each axis, (2, 3)."""
    span = np.empty((2, 3))
    span[0], span[1] = np.inf, -np.inf
    for t in range(len(triangles)):
        for corner in range(3):
            for axis in range(3):
                span[0, axis] = min(span[0, axis], triangles[t, corner, axis])
                span[1, axis] = max(span[1, axis], triangles[t, corner, axis])
    return span


@compiled
def _to_texels(triangles: F64, texel: float, start: F64) -> None:
    """Convert x and y of (n, 3, 3) corners to a map's columns and rows, in place."""
    for t in range(len(triangles)):
        for corner in range(3):
            for axis in range(2):
                texels = triangles[t, corner, axis] / texel - start[axis]
                triangles[t, corner, axis] = texels
