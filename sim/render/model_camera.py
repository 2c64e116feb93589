"""The cameras of a MuJoCo model: by name, and as pinholes."""

from __future__ import annotations

import math

import mujoco

from sim.errors import SceneConfigError
from sim.geometry.pinhole import Intrinsics

SQUARE = 1e-3
"""By what part a pixel may be longer than wide (assumed)."""


def camera_number(model: mujoco.MjModel, camera: str) -> int:
    """A camera's number by its name.

    Raises:
        SceneConfigError: no such camera.
    """
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_CAMERA, camera)
    if number >= 0:
        return int(number)
    names = ", ".join(repr(model.cam(k).name) for k in range(model.ncam) if model.cam(k).name)
    there = f"allowed is one of {names}; choose one of them" if names else "it has none with a name"
    raise SceneConfigError(
        f'the model has no camera {camera!r}; {there}, or add <camera name="{camera}" .../>'
    )


def camera_intrinsics(
    model: mujoco.MjModel, camera: str, *, width: int | None = None, height: int | None = None
) -> Intrinsics:
    """Size and focal length of a model's camera.

    MuJoCo gives it either by `fovy`, the angle over the image's height, or by `focal` and
    `sensorsize`; from the latter it works out the former.

    Args:
        model: the model.
        camera: name of its camera.
        width: of the image [px]; None: the camera's resolution.
        height: likewise.

    Raises:
        SceneConfigError: no such camera; neither a size nor a resolution; a camera that is
            orthographic, has its axis off the middle, or pixels that are not square.
    """
    k = camera_number(model, camera)
    resolution = [int(n) for n in model.cam_resolution[k]]
    width, height = (
        given if given is not None else own
        for given, own in zip((width, height), resolution, strict=True)
    )
    if width < 2 or height < 2:
        raise SceneConfigError(
            f"the image of camera {camera!r} is {width} by {height} px; allowed is 2 and more; "
            'give width= and height=, or the camera a resolution="346 260"'
        )
    if model.cam_projection[k] != mujoco.mjtProjection.mjPROJ_PERSPECTIVE:
        raise SceneConfigError(
            f"camera {camera!r} is orthographic; allowed is a perspective one; leave its "
            "projection out"
        )
    focal_px = height / 2 / math.tan(math.radians(float(model.cam_fovy[k])) / 2)
    if model.cam_sensorsize[k].all():
        _check_sensor(model, camera, k, width, focal_px)
    return Intrinsics(width, height, focal_px)


def _check_sensor(model: mujoco.MjModel, camera: str, k: int, width: int, focal_px: float) -> None:
    across_px = float(model.cam_intrinsic[k, 0] / model.cam_sensorsize[k, 0]) * width
    if abs(across_px / focal_px - 1) > SQUARE:
        raise SceneConfigError(
            f"camera {camera!r} has a focal length of {across_px:.2f} pixels across and "
            f"{focal_px:.2f} down; allowed are square pixels; give a sensorsize in proportion to "
            "the image's size, and one focal length"
        )
    if model.cam_intrinsic[k, 2:].any():
        raise SceneConfigError(
            f"camera {camera!r} has its axis {model.cam_intrinsic[k, 2:].tolist()} m off the "
            "sensor's middle; allowed is none; leave its principal point out"
        )
