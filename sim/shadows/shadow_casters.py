"""Static geoms that may shade a moving object. All others can be hidden while it is rendered."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]

SUN_DISTANCE_M = 1e3
"""Distance at which the sun is placed: beyond anything that shades the street (assumed)."""


def shadow_casting_geoms(
    model: mujoco.MjModel, data: mujoco.MjData, candidates: Numbers, corners_m: F64
) -> Numbers:
    """Return the geoms that may cast a shadow on an object.

    A geom qualifies if its bounding sphere touches the cylinder between a light and the object,
    whose radius is that of the object's bounding sphere.

    Args:
        model: model with the lights.
        data: positions of geoms and lights.
        candidates: (n,) numbers of the geoms to choose from.
        corners_m: (8, 3) corners of the object's bounding box in the world [m].
    """
    centre = corners_m.mean(axis=0)
    casting = candidates[model.geom_castshadow[candidates]]
    radius_m = np.linalg.norm(corners_m - centre, axis=1).max()
    bound_m = model.geom_rbound[casting]
    offset = data.geom_xpos[casting] - centre
    may_shade = bound_m == 0  # planes are unbounded
    for light in _casting_lights(model):
        is_sun = model.light_type[light] == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
        to_light = (
            -SUN_DISTANCE_M * data.light_xdir[light] if is_sun else data.light_xpos[light] - centre
        )
        along = np.clip(offset @ to_light / (to_light @ to_light), 0.0, 1.0)[:, None]
        may_shade |= np.linalg.norm(offset - along * to_light, axis=1) <= bound_m + radius_m
    return np.asarray(casting[may_shade])


def _casting_lights(model: mujoco.MjModel) -> Numbers:
    image = model.light_type == mujoco.mjtLightType.mjLIGHT_IMAGE
    return np.flatnonzero(model.light_castshadow & (model.light_intensity > 0) & ~image)
