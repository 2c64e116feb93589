"""Spot lights whose beam misses an object. They can be off while the object is rendered."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.rigid_transform import axes_along

F64 = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

TANGENT_PLANES = 8
"""Planes that touch a cone, evenly around it. More would separate it from more triangles
(assumed)."""


def beams_that_miss(
    model: mujoco.MjModel, data: mujoco.MjData, lights: Numbers, triangles_m: F64
) -> Numbers:
    """Return the spot lights whose cone is separated from each triangle of an object.

    Args:
        model: model with the lights.
        data: poses of the lights.
        lights: (n,) numbers of the spot lights to choose from.
        triangles_m: (m, 3, 3) triangles of the object in the world [m].
    """
    missed = [
        _separated_from_cone(
            triangles_m - data.light_xpos[k],
            data.light_xdir[k],
            math.radians(model.light_cutoff[k]),
        ).all()
        for k in lights
    ]
    return lights[np.array(missed, np.bool_)]


def _separated_from_cone(triangles_m: F64, axis: F64, angle_rad: float) -> Bools:
    """Return True for each triangle that a plane through the cone's tip separates from the cone.

    The planes are the one across the axis, and `TANGENT_PLANES` that touch the cone.

    Args:
        triangles_m: (m, 3, 3) triangles, relative to the cone's tip [m].
        axis: (3,) unit vector from the tip along the cone.
        angle_rad: angle between axis and rim, at most π/2.
    """
    turn = np.arange(TANGENT_PLANES)[:, None] * (2 * math.pi / TANGENT_PLANES)
    right, down, _ = axes_along(axis)
    outward = np.cos(turn) * right + np.sin(turn) * down
    tangent = math.cos(angle_rad) * outward - math.sin(angle_rad) * axis
    beyond = triangles_m @ np.concatenate([tangent, -axis[None]]).T > 0
    return np.asarray(beyond.all(axis=1).any(axis=1))
