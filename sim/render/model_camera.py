"""Look-up of a MuJoCo model's cameras, and their intrinsics."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from sim.errors import SceneConfigError
from sim.geometry.pinhole import Intrinsics

SQUARE_TOLERANCE = 1e-6
"""Relative difference between two focal lengths up to which pixels count as square (assumed; MuJoCo
stores them as float32)."""


def camera_id(model: mujoco.MjModel, camera: str) -> int:
    """Return the number of the camera with a given name.

    Raises:
        SceneConfigError: the model has no such camera.
    """
    found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_CAMERA, camera)
    if found >= 0:
        return int(found)
    names = ", ".join(repr(model.cam(k).name) for k in range(model.ncam) if model.cam(k).name)
    existing = f"Allowed is one of {names}" if names else "None of its cameras has a name"
    raise SceneConfigError(
        f"the model has no camera {camera!r}. {existing}. Add "
        f'<camera name="{camera}" .../> to the model, or name a camera that it has.'
    )


def camera_intrinsics(
    model: mujoco.MjModel, camera: str, *, width: int | None = None, height: int | None = None
) -> Intrinsics:
    """Return the intrinsics of a model's camera.

    A model gives the vertical field of view, `fovy`, and pixels are square. Or it gives
    `sensorsize`, `focal` and perhaps `principal`. Then the whole sensor fills the image, whatever
    the shape of both, as in MuJoCo's own renderers.

    Args:
        model: model with the camera.
        camera: name of the camera.
        width: width of the image [px]; None: from the camera's resolution.
        height: height of the image [px]; None: from the camera's resolution.

    Raises:
        SceneConfigError: the model has no such camera; the image has no size; or the camera is
            orthographic.
    """
    k = camera_id(model, camera)
    width = int(model.cam_resolution[k, 0]) if width is None else width
    height = int(model.cam_resolution[k, 1]) if height is None else height
    if width < 2 or height < 2:
        raise SceneConfigError(
            f"the image of camera {camera!r} is {width} by {height} px. Allowed is 2 px or more. "
            'Pass width= and height=, or set resolution="346 260" on the camera.'
        )
    if model.cam_projection[k] != mujoco.mjtProjection.mjPROJ_PERSPECTIVE:
        raise SceneConfigError(
            f"camera {camera!r} is orthographic. Allowed is a perspective camera. Remove its "
            "projection attribute."
        )
    focal_y = height / 2 / math.tan(math.radians(float(model.cam_fovy[k])) / 2)
    if not model.cam_sensorsize[k].all():
        return Intrinsics(width, height, focal_y)
    focal_x, _, right, down = model.cam_intrinsic[k] / np.tile(model.cam_sensorsize[k], 2)
    focal_x, aspect = focal_x * width, focal_y / (focal_x * width)
    if abs(aspect - 1) < SQUARE_TOLERANCE:
        focal_x, aspect = focal_y, 1.0
    # MuJoCo moves the image by `principal`, to the right and down, and thus the axis back.
    axis_px = (0.0 - float(right) * width, 0.0 - float(down) * height)
    return Intrinsics(width, height, float(focal_x), float(aspect), axis_px)
