"""Intrinsics of the cameras of MuJoCo models."""

import math

import mujoco
import pytest

from sim.errors import SceneConfigError
from sim.render.model_camera import camera_id, camera_intrinsics


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
    ("attributes", "message"),
    [
        ('fovy="45"', "is 1 by 1 px. Allowed is 2 px or more. Pass width= and height="),
        ('resolution="64 48" projection="orthographic"', "orthographic. Allowed is a perspective"),
        (
            'resolution="64 48" sensorsize="6e-3 6e-3" focal="6e-3 6e-3"',
            "64.00 px across and 48.00 px down. Allowed are square pixels",
        ),
        (
            'resolution="64 48" sensorsize="8e-3 6e-3" focal="6e-3 6e-3" principal="1e-3 0"',
            "off the middle of the sensor",
        ),
    ],
)
def test_cameras_that_are_no_central_pinholes_are_refused(attributes: str, message: str) -> None:
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
