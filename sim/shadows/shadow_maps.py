"""How near the movers are to each lamp, direction by direction: whom they stand in the light of.

Each pair of a light and a moving object has a map of its own, drawn anew at every sample, since
what an object shuts out changes with its place.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.rigid_transform import axes_along, compose_transforms, world_to_frame
from sim.raster.scan_conversion import perspective, rasterise
from sim.raster.triangles import Soup
from sim.scene.moving_objects import MovingObject

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]

MAP_SIDE = 512
"""Rows and columns that a map may have (assumed: a van's shadow in cells of `TEXEL_M`)."""
TEXEL_M = 0.025
"""Side of a map's cell on the ground, where the map's size allows it; what a pixel
sees at the vehicle's distance (assumed)."""
LAMP_NEAR_M = 0.1
"""Nothing stands nearer to a lamp (assumed)."""
EMPTY = np.float32(-np.inf)
"""Nearness where nothing stands before the light."""


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
        What it was drawn through; None where it casts no shadow, or where the lamp cannot see it.
    """
    to_light = world_to_frame(lamp.axes, data.xpos[obj.root] if lamp.parallel else lamp.place_m)
    local = soup.moved(compose_transforms(poses, to_light))
    if not len(local):
        return None
    if lamp.parallel:
        texel = TEXEL_M
        local[..., 2] *= -1
    else:
        farthest_m = _span(local)[1, 2]
        if farthest_m < LAMP_NEAR_M:
            return None
        texel = TEXEL_M / farthest_m
        local, _ = perspective(local, 1.0, 0.0, 0.0, LAMP_NEAR_M)
    low, high = _span(local)[:, :2]
    texel = max(texel, float((high - low).max()) / (MAP_SIDE - 7))
    start = np.floor(low / texel) - 2
    columns, rows = (int(n) for n in np.ceil(high / texel) - start + 3)
    _onto_map(local, texel, start)
    used = out[:rows, :columns]
    used.fill(EMPTY)
    nobody, nowhere = np.zeros(len(local), np.int32), np.empty(used.shape, np.int32)
    rasterise(local, nobody, 0, 0, used, nowhere, True)
    last = -to_light[2:] if lamp.parallel else to_light[2:]
    shift = np.outer(start, [0, 0, 0, 1] if lamp.parallel else to_light[2])
    return ShadowMap(np.concatenate([to_light[:2] / texel - shift, last]), (rows, columns))


@compiled
def _span(triangles: F64) -> F64:
    """(2, 3) lowest and highest of (n, 3, 3) corners, along each axis."""
    span = np.empty((2, 3))
    span[0], span[1] = np.inf, -np.inf
    for t in range(len(triangles)):
        for corner in range(3):
            for axis in range(3):
                span[0, axis] = min(span[0, axis], triangles[t, corner, axis])
                span[1, axis] = max(span[1, axis], triangles[t, corner, axis])
    return span


@compiled
def _onto_map(triangles: F64, texel: float, start: F64) -> None:
    """Bring the x and y of (n, 3, 3) corners to a map's columns and rows, in place."""
    for t in range(len(triangles)):
        for corner in range(3):
            for axis in range(2):
                place = triangles[t, corner, axis] / texel - start[axis]
                triangles[t, corner, axis] = place
