"""Which still things may keep light from a mover: all others can be away while it is drawn."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

from sim.render.filament import NO_SHADOW_GROUP

F64 = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]

SUN_M = 1e3
"""Farther off than anything that shades the street from the sun (assumed)."""


def shadow_casting_geoms(
    model: mujoco.MjModel, data: mujoco.MjData, still: Numbers, corners_m: F64
) -> Numbers:
    """Those of some geoms that may cast a shadow on a thing.

    They lie between a lamp and the ball around the thing: no farther from the line between the
    lamp and the ball's middle than the ball reaches.

    Args:
        model: whose lights shine.
        data: where geoms and lights are.
        still: (n,) numbers of the geoms to choose from.
        corners_m: (8, 3) of the box around the thing, in the world [m].
    """
    middle = corners_m.mean(axis=0)
    casting = still[model.geom_group[still] != NO_SHADOW_GROUP]
    ball_m, bound_m = np.linalg.norm(corners_m - middle, axis=1).max(), model.geom_rbound[casting]
    place = data.geom_xpos[casting] - middle
    near = bound_m == 0  # planes have no end
    for light in _casting_lights(model):
        parallel = model.light_type[light] == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
        way = -SUN_M * data.light_xdir[light] if parallel else data.light_xpos[light] - middle
        along = np.clip(place @ way / (way @ way), 0.0, 1.0)[:, None]
        near |= np.linalg.norm(place - along * way, axis=1) <= bound_m + ball_m
    return np.asarray(casting[near])


def _casting_lights(model: mujoco.MjModel) -> Numbers:
    image = model.light_type == mujoco.mjtLightType.mjLIGHT_IMAGE
    return np.flatnonzero(model.light_castshadow & (model.light_intensity > 0) & ~image)
