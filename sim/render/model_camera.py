"""Look-up of a MuJoCo model's cameras, and their intrinsics."""

from __future__ import annotations

import math

import mujoco

from sim.errors import SceneConfigError
from sim.geometry.pinhole import Intrinsics

ASPECT_TOLERANCE = 1e-3
"""Relative difference between a pixel's width and height up to which it counts as square
(assumed)."""


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
    """Return the image size and the focal length of a model's camera.

    A model gives the focal length by `fovy`, the vertical field of view, or by `focal` and
    `sensorsize`. MuJoCo computes `fovy` in the second case.

    Args:
        model: model with the camera.
        camera: name of the camera.
        width: width of the image [px]; None: from the camera's resolution.
        height: height of the image [px]; None: from the camera's resolution.

    Raises:
        SceneConfigError: the model has no such camera; the image has no size; or the camera is
            orthographic, has its optical axis off the middle, or has pixels that are not square.
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
    focal_px = height / 2 / math.tan(math.radians(float(model.cam_fovy[k])) / 2)
    if model.cam_sensorsize[k].all():
        _check_sensor(model, camera, k, width, focal_px)
    return Intrinsics(width, height, focal_px)


def _check_sensor(model: mujoco.MjModel, camera: str, k: int, width: int, focal_px: float) -> None:
    across_px = float(model.cam_intrinsic[k, 0] / model.cam_sensorsize[k, 0]) * width
    if abs(across_px / focal_px - 1) > ASPECT_TOLERANCE:
        raise SceneConfigError(
            f"camera {camera!r} has a focal length of {across_px:.2f} px across and "
            f"{focal_px:.2f} px down. Allowed are square pixels. Make sensorsize proportional to "
            "the image size, and give one focal length."
        )
    if model.cam_intrinsic[k, 2:].any():
        raise SceneConfigError(
            f"camera {camera!r} has its optical axis {model.cam_intrinsic[k, 2:].tolist()} m off "
            "the middle of the sensor. Allowed is 0. Remove its principal attribute."
        )
