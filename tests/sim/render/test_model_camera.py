"""Intrinsics of the cameras of MuJoCo models."""

import math

import mujoco
import numpy as np
import pytest

from sim.errors import SceneConfigError
from sim.geometry.pinhole import Pose, project
from sim.render.model_camera import camera_id, camera_intrinsics

DOWN = Pose(np.zeros(3), up=np.array([0.0, 1.0, 0.0]))
"""Pose of a camera whose frame is MuJoCo's: x right, y up, looking along -z."""


def model_with_cameras(more: str = "") -> mujoco.MjModel:
    cameras = f'<camera name="down" fovy="40"/><camera name="side"/>{more}'
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{cameras}</worldbody></mujoco>")


def test_the_focal_length_comes_from_fovy_or_from_focal_and_sensorsize() -> None:
    lens = 'sensorsize="6.401e-3 4.81e-3" focal="6e-3 6e-3" resolution="346 260"'
    model = model_with_cameras(f'<camera name="lens" {lens}/>')
    by_angle = camera_intrinsics(model, "down", width=100, height=80)
    assert by_angle.focal_px == pytest.approx(40 / math.tan(math.radians(20)))
    by_lens = camera_intrinsics(model, "lens")
    assert (by_lens.width, by_lens.height) == (346, 260)
    assert by_lens.focal_px == pytest.approx(6e-3 / 18.5e-6)
    assert camera_intrinsics(model, "lens", width=173, height=130).focal_px == pytest.approx(
        3e-3 / 18.5e-6
    )


@pytest.mark.parametrize(
    ("attributes", "focal_px", "aspect", "axis_px"),
    [
        ('sensorsize="8e-3 6e-3" focal="6e-3 6e-3"', 48, 1, (0, 0)),
        ('sensorsize="6e-3 6e-3" focal="6e-3 6e-3"', 64, 0.75, (0, 0)),
        ('sensorsize="8e-3 6e-3" focal="6e-3 9e-3"', 48, 1.5, (0, 0)),
        ('sensorsize="8e-3 6e-3" focal="6e-3 6e-3" principal="1e-3 -2e-3"', 48, 1, (-8, 16)),
        ('sensorsize="8e-3 6e-3" focalpixel="48 60" principalpixel="4 2"', 48, 1.25, (-4, -2)),
    ],
)
def test_the_lens_is_that_of_mujocos_own_frustum(
    attributes: str, focal_px: float, aspect: float, axis_px: tuple[float, float]
) -> None:
    model = model_with_cameras(f'<camera name="lens" resolution="64 48" {attributes}/>')
    lens = camera_intrinsics(model, "lens")
    assert (lens.focal_px, lens.aspect) == pytest.approx((focal_px, aspect), rel=1e-6)
    assert lens.axis_px == pytest.approx(axis_px, abs=1e-5)
    data, camera = mujoco.MjData(model), mujoco.MjvCamera()
    mujoco.mj_forward(model, data)
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, camera_id(model, "lens")
    seen = mujoco.mjv_camera2GLCamera(model, data, camera)
    corner = np.array([seen.frustum_center - seen.frustum_width, seen.frustum_top, -1.0])
    pixel, _ = project(corner[None] * [1, 1, seen.frustum_near], DOWN, lens)
    assert pixel[0] == pytest.approx([0, 0], abs=1e-4)


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ('fovy="45"', "is 1 by 1 px. Allowed is 2 px or more. Pass width= and height="),
        ('resolution="64 48" projection="orthographic"', "orthographic. Allowed is a perspective"),
    ],
)
def test_cameras_without_a_size_or_a_perspective_are_refused(attributes: str, message: str) -> None:
    model = model_with_cameras(f'<camera name="odd" {attributes}/>')
    with pytest.raises(SceneConfigError, match=message):
        camera_intrinsics(model, "odd")


def test_the_error_for_a_missing_camera_lists_the_existing_cameras() -> None:
    with pytest.raises(
        SceneConfigError, match=r"no camera 'eye'\. Allowed is one of 'down', 'side'"
    ):
        camera_id(model_with_cameras(), "eye")
    bare = mujoco.MjModel.from_xml_string("<mujoco/>")
    with pytest.raises(SceneConfigError, match="None of its cameras has a name"):
        camera_id(bare, "eye")
