import math

import numpy as np
import pytest

from sim import CrossingConfig, Intrinsics, Pose, project
from sim.distractors import Distractors
from sim.motion.band_limited_noise import BandLimitedNoise
from sim.motion.camera_shake import Shake, camera_shake, rotation
from sim.scene.scene import build_scene

REST = Pose(np.array([0.0, -7.8, 1.2]))
FAR = np.array([[0.0, 1e6, 1.2]])


def still(radians: float) -> BandLimitedNoise:
    return BandLimitedNoise(radians, np.zeros(1), np.array([math.pi / 2]))


@pytest.mark.parametrize("vector", [[0.3, 0, 0], [0, -0.2, 0], [0.1, 0.2, -0.3]])
def test_a_rotation_vector_turns_about_itself_by_its_length(vector: list[float]) -> None:
    turn = rotation(np.array(vector))
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(turn @ vector, vector, atol=1e-12)
    assert np.trace(turn) == pytest.approx(1 + 2 * math.cos(np.linalg.norm(vector)))


@pytest.mark.parametrize(
    ("axis", "shift_px"), [(0, [0, 1]), (1, [-1, 0])]
)  # looking up moves the image down; looking right moves it left
def test_small_turns_shift_a_far_point_by_focal_length_times_angle(
    axis: int, shift_px: list[float]
) -> None:
    angles = [0.0, 0.0, 0.0]
    angles[axis] = 1e-3
    shake = Shake((still(angles[0]), still(angles[1]), still(angles[2])))
    lens = Intrinsics()
    before, _ = project(FAR, REST, lens)
    after, _ = project(FAR, shake.turned(REST, 0.0), lens)
    assert (after - before)[0] == pytest.approx(np.array(shift_px) * 1e-3 * lens.focal_px, abs=1e-3)


def test_roll_turns_the_image_about_its_middle() -> None:
    shake = Shake((still(0.0), still(0.0), still(0.01)))
    turned = shake.turned(REST, 0.0)
    np.testing.assert_allclose(turned.forward, REST.forward, atol=1e-12)
    assert math.acos(turned.right @ REST.right) == pytest.approx(0.01)


def test_the_shake_has_the_configured_deviation_about_each_axis() -> None:
    shake = camera_shake(0.2, 4.0, seed=3)
    angles = np.array([shake.rotation_rad(t_s) for t_s in np.arange(0, 150, 0.013)])
    assert np.degrees(np.sqrt((angles**2).mean(axis=0))) == pytest.approx([0.2] * 3, rel=0.03)
    correlation = np.corrcoef(angles.T)
    assert np.abs(correlation - np.eye(3)).max() < 0.05


def test_the_camera_stays_where_it_is_and_its_axes_stay_square() -> None:
    pose = camera_shake(1.0, 4.0, seed=0).turned(REST, 0.37)
    np.testing.assert_array_equal(pose.position_m, REST.position_m)
    axes = np.stack([pose.right, pose.up, pose.forward])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)


def test_no_direction_turns_faster_than_the_bound() -> None:
    shake, step_s = camera_shake(1.0, 8.0, seed=5), 1e-6
    for t_s in np.linspace(-1, 1, 21):
        forward = [shake.turned(REST, t_s + way * step_s).forward for way in (-1, 1)]
        assert np.linalg.norm(forward[1] - forward[0]) / (2 * step_s) <= (
            shake.fastest_rad_s(t_s) * 1.001
        )


def test_a_scene_shakes_only_if_configured() -> None:
    rest = build_scene(CrossingConfig())
    assert rest.pose_at(0.3) is rest.pose
    shaken = build_scene(CrossingConfig(distractors=Distractors(shake_rms_deg=0.2)))
    assert not np.array_equal(shaken.pose_at(0.3).right, shaken.pose.right)
    again = build_scene(CrossingConfig(distractors=Distractors(shake_rms_deg=0.2)))
    assert np.array_equal(shaken.pose_at(0.3).right, again.pose_at(0.3).right)
