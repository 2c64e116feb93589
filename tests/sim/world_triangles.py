"""Triangles of a model in world coordinates, geom by geom."""

from collections.abc import Iterable

import mujoco
import numpy as np
import numpy.typing as npt

from sim.raster.triangles import geom_triangles

F64 = npt.NDArray[np.float64]


def world_triangles(model: mujoco.MjModel, data: mujoco.MjData, geoms: Iterable[int]) -> F64:
    """Return the (n, 3, 3) triangles of some geoms in the world [m]."""
    return np.concatenate([geom_triangles(model, data, int(geom)) for geom in geoms])


def world_points(model: mujoco.MjModel, data: mujoco.MjData, geoms: Iterable[int]) -> F64:
    """Return the (3n, 3) corners of the triangles of some geoms in the world [m]."""
    return world_triangles(model, data, geoms).reshape(-1, 3)
