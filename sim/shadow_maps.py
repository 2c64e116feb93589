"""How near the movers are to each lamp, direction by direction: whom they stand in the light of.

Each pair of a light and a moving object has a map of its own, drawn anew at every sample, since
what an object shuts out changes with its place.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.moves import axes_along, followed_by, into_frame
from sim.objects import MovingObject
from sim.raster import perspective, rasterise, transform
from sim.triangles import Soup

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]

MAP_SIDE = 512
"""Rows and columns that a map may have."""
TEXEL_M = 0.025
"""Side of a map's cell on the ground, where the map's size allows it; what a pixel
sees at the vehicle's distance (assumed)."""
LAMP_NEAR_M = 0.1
"""Nothing stands nearer to a lamp (assumed)."""
EMPTY = np.float32(-np.inf)


@dataclass(frozen=True, eq=False)
class Lamp:
    """A light that casts shadows.

    Attributes:
        axes: (3, 3) rows: the map's right and down, and away from the light.
        place_m: (3,) where it is; for the sun, anywhere.
        parallel: whether it is the sun.
    """

    axes: F64
    place_m: F64
    parallel: bool


def shadowing_lamps(model: mujoco.MjModel, data: mujoco.MjData, lights: I64) -> list[Lamp]:
    """The lights of these numbers, sun and spots."""
    return [
        Lamp(
            axes_along(data.light_xdir[k]),
            data.light_xpos[k].copy(),
            bool(model.light_type[k] == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL),
        )
        for k in lights
    ]


@dataclass(frozen=True, eq=False)
class ShadowMap:
    """One object before one light.

    Attributes:
        view: (3, 4) from the world to columns, rows and nearness; homogeneous for a lamp.
        size: rows and columns in use.
    """

    view: F64
    size: tuple[int, int]


def draw_shadow_map(
    lamp: Lamp, obj: MovingObject, soup: Soup, data: mujoco.MjData, poses: F64, out: F32
) -> ShadowMap | None:
    """Draw how near an object is to a light.

    Args:
        lamp: the light.
        obj: what stands before it.
        soup: the triangles of the object that cast shadows.
        data: where it is.
        poses: (bodies, 3, 4) of all bodies in the world.
        out: (`MAP_SIDE`, `MAP_SIDE`) float32, of which the map takes the upper left part.

    Returns:
        What it was drawn through; None where the lamp cannot see the object.
    """
    origin = data.xpos[obj.root] if lamp.parallel else lamp.place_m
    corners = (obj.corners_m(data) - origin) @ lamp.axes.T
    if lamp.parallel:
        flat, texel = corners[:, :2], TEXEL_M
    else:
        if corners[:, 2].max() < LAMP_NEAR_M:
            return None
        depth = np.maximum(corners[:, 2], LAMP_NEAR_M)
        flat, texel = corners[:, :2] / depth[:, None], TEXEL_M / float(depth.max())
    low, high = flat.min(axis=0), flat.max(axis=0)
    texel = max(texel, float((high - low).max()) / (MAP_SIDE - 7))
    start = np.floor(low / texel) - 2
    columns, rows = (int(n) for n in np.ceil(high / texel) - start + 3)
    to_light = into_frame(lamp.axes, origin)
    local = transform(soup.triangles_m, soup.body, followed_by(poses, to_light))
    used = out[:rows, :columns]
    used.fill(EMPTY)
    nobody = np.empty(used.shape, np.int32)
    if lamp.parallel:
        local[..., :2] = local[..., :2] / texel - start
        local[..., 2] *= -1
        triangles = local
        view = np.concatenate([to_light[:2] / texel - np.outer(start, [0, 0, 0, 1]), -to_light[2:]])
    else:
        triangles, _ = perspective(local, 1 / texel, -start[0], -start[1], LAMP_NEAR_M)
        view = np.concatenate([to_light[:2] / texel - np.outer(start, to_light[2]), to_light[2:]])
    rasterise(triangles, soup.body, 0, 0, used, nobody, True)
    return ShadowMap(view, (rows, columns))
