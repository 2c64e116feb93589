"""Depth and optical flow of a scene, compared with the closed forms of its motions."""

import numpy as np
import pytest

from flybench.direction import CARDINAL, Direction
from sim.config import CrossingConfig
from sim.distractors import Distractors
from sim.geometry.pinhole import Intrinsics
from sim.motion.band_limited_noise import band_limited_noise
from sim.scene.scene import build_scene
from sim.truth.dense_truth import DenseTruth


@pytest.mark.parametrize("direction", CARDINAL)
def test_the_flow_of_the_targets_flank_is_f_v_over_z(direction: str) -> None:
    scene, lens = build_scene(CrossingConfig(direction=Direction(direction))), Intrinsics()
    geometry = DenseTruth(scene, lens)
    visible, flow = geometry.visible(0.1), geometry.flow_px_s(0.1)
    body = visible.body == scene.target.root
    assert body.sum() > 5_000
    expected = lens.focal_px * scene.trajectory.speed_m_s(0.1) * visible.nearness[body]
    along = {"right": (0, 1), "left": (0, -1), "up": (1, -1), "down": (1, 1)}[direction]
    axis, sign = along
    assert flow[body][:, axis] == pytest.approx(sign * expected, rel=1e-5)
    assert np.abs(flow[body][:, 1 - axis]).max() < 1e-3
    assert np.abs(flow[visible.body <= 0]).max() < 1e-3


def test_a_rolling_wheel_has_no_speed_at_the_road_and_twice_the_vehicles_on_top() -> None:
    scene, lens = build_scene(CrossingConfig()), Intrinsics()
    geometry, speed = DenseTruth(scene, lens), scene.trajectory.speed_m_s(0.0)
    wheel = int(scene.model.body("vehicle/wheel_front_right").id)
    view, twist = geometry.poses_in_camera(0.0)[wheel], geometry.twists(0.0)[wheel]
    axle = view[:, 3]
    radius = scene.model.body_pos[wheel, 2]
    for height, factor in ((-radius, 0.0), (0.0, 1.0), (radius, 2.0)):
        place = axle - np.array([0.0, height, 0.0])  # the camera's y is down
        velocity = twist[:, :3] @ place + twist[:, 3]
        assert velocity == pytest.approx([factor * speed, 0, 0], abs=1e-6 * speed)
    visible, flow = geometry.visible(0.0), geometry.flow_px_s(0.0)
    rows, columns = np.nonzero(visible.body == wheel)
    depth = 1 / visible.nearness[rows, columns].astype(np.float64)
    right = (columns + 0.5 - lens.width / 2) / lens.focal_px * depth - axle[0]
    down = (rows + 0.5 - lens.height / 2) / lens.focal_px * depth - axle[1]
    expected = lens.focal_px / depth * speed * np.array([1 - down / radius, right / radius])
    assert rows.size > 200
    assert pytest.approx(expected, abs=0.02) == flow[rows, columns].T


def test_central_differences_of_10_us_have_the_documented_error_for_a_shake() -> None:
    noise = band_limited_noise(np.random.default_rng(1), rms=0.05, corner_hz=50.0)
    times = np.linspace(0, 0.5, 200)
    found = np.array([(noise.value(t + 1e-5) - noise.value(t - 1e-5)) / 2e-5 for t in times])
    assert np.abs(found - [noise.rate(t) for t in times]).max() < 2e-4 * noise.rms_rate


def test_a_shaking_camera_sees_the_background_flow_of_its_rotation() -> None:
    """Compared with the flow of a rotation at the rate from the shake's closed form."""
    config = CrossingConfig(distractors=Distractors(shake_rms_deg=0.3, seed=4))
    scene, lens = build_scene(config), Intrinsics()
    assert scene.shake is not None
    geometry, shake = DenseTruth(scene, lens), scene.shake
    rate = np.array([axis.rate(0.2) for axis in shake.axes])
    a, b, c = rate - np.cross(shake.rotation_rad(0.2), rate) / 2  # the next term is 10⁻⁵ of it
    flow, background = geometry.flow_px_s(0.2), geometry.visible(0.2).body <= 0
    x = (np.arange(lens.width) + 0.5 - lens.width / 2) / lens.focal_px
    y = ((np.arange(lens.height) + 0.5 - lens.height / 2) / lens.focal_px)[:, None]
    right = lens.focal_px * (-b + c * y + a * x * y - b * x * x)
    down = lens.focal_px * (a - c * x + a * y * y - b * x * y)
    assert np.abs(flow[background]).max() > 5.0
    assert flow[background, 0] == pytest.approx(right[background], abs=2e-3)
    assert flow[background, 1] == pytest.approx(down[background], abs=2e-3)


def test_displacement_over_a_short_time_equals_flow_times_time() -> None:
    scene = build_scene(CrossingConfig(distractors=Distractors(shake_rms_deg=0.3, wind_grade=5)))
    geometry = DenseTruth(scene, Intrinsics())
    flow, step = geometry.flow_px_s(0.1), 1e-5
    ahead, back = (geometry.displacement_px(0.1, 0.1 + s) for s in (step, -step))
    assert (ahead - back) / (2 * step) == pytest.approx(flow, abs=0.01)
