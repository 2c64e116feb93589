"""Motion between frames, and interpolation."""

from typing import Any

import numpy as np
import pytest

from scenarios.emulate.motion import MotionMeter, interpolated, interpolation_count
from tests.scenarios.emulate.moving_pictures import bar, grating, wall


@pytest.mark.parametrize("shift", [0.0, 0.5, 3.0, 8.0])
def test_the_motion_of_a_wall_is_measured(shift: float) -> None:
    meter = MotionMeter(100.0)
    before, after = 100 * wall(0), 100 * wall(shift)
    flow = meter.flow_px(before, after)
    assert np.median(flow[20:-20, 20:-20, 0]) == pytest.approx(shift, abs=0.1)
    assert meter.motion_px(before, after, flow) == pytest.approx(shift, abs=0.1 + 0.1 * shift)


@pytest.mark.parametrize("stimulus", [bar, grating])
def test_flow_along_a_stripe_does_not_count(stimulus: Any) -> None:
    """The stripes move by 2 px per frame; flow along them is arbitrary (the aperture problem)."""
    meter, found, longest = MotionMeter(100.0), [], 0.0
    for k in range(12):
        before, after = (100 * stimulus(2.0 * frame, rows=260, columns=346) for frame in (k, k + 1))
        flow = meter.flow_px(before, after)
        longest = max(longest, float(np.hypot(*flow.reshape(-1, 2).T).max()))
        found.append(meter.motion_px(before, after, flow))
    assert longest > 20.0  # the flow itself is wrong
    assert max(found) == pytest.approx(2.0, abs=0.2)
    assert interpolation_count(max(found), 0.5) < 5


@pytest.mark.parametrize("brightest", [0.01, 1.0, 200.0, 5e3, 1e5])
@pytest.mark.parametrize("shift", [0.0, 3.0])
def test_motion_is_measured_at_any_luminance(brightest: float, shift: float) -> None:
    meter = MotionMeter(None)
    before, after = brightest * wall(0), brightest * wall(shift)
    found = meter.motion_px(before, after, meter.flow_px(before, after))
    assert found == pytest.approx(shift, abs=0.1 + 0.1 * shift)


@pytest.mark.parametrize(("dark", "lamp"), [(0.0, 1e3), (0.01, 1e5), (10.0, 1e9)])
def test_a_lamp_and_deep_shadow_do_not_hide_motion(dark: float, lamp: float) -> None:
    """Most of the picture is dark or black, a lamp is far brighter, and a wall moves by 3 px."""
    meter = MotionMeter(None)
    before, after = (np.full((130, 346), dark, np.float32) for _ in range(2))
    for image, shift in ((before, 0.0), (after, 3.0)):
        image[:, :173] = 100 * wall(shift)
        image[:9, 300:309] = lamp
    found = meter.motion_px(before, after, meter.flow_px(before, after))
    assert found == pytest.approx(3.0, abs=0.6)


def test_noise_of_a_flat_scene_is_not_motion() -> None:
    """Noise of 0.3 % on a wall of low contrast that does not move."""
    meter, rng = MotionMeter(None), np.random.default_rng(0)
    noise = rng.normal(size=(2, 130, 173)).astype(np.float32)
    before, after = 5e3 * (1 + 0.1 * wall(0)) * (1 + 0.003 * noise)
    assert meter.motion_px(before, after, meter.flow_px(before, after)) < 0.2


@pytest.mark.parametrize("white", [100.0, None])
def test_flicker_is_not_motion(white: float | None) -> None:
    meter, dark = MotionMeter(white), np.full((130, 173), 20.0, np.float32)
    assert meter.motion_px(dark, 2 * dark, meter.flow_px(dark, 2 * dark)) == 0.0


def test_a_small_object_in_front_of_a_static_wall_is_measured() -> None:
    """0.4 % of the picture moves by 4 px; the rest is static."""
    meter, background = MotionMeter(100.0), 100 * wall(0)
    before, after = background.copy(), background.copy()
    patch = 100 * wall(0)[:10, :9] * 0.3
    before[60:70, 60:69] = patch
    after[60:70, 64:73] = patch
    found = meter.motion_px(before, after, meter.flow_px(before, after))
    assert 2.0 < found < 8.0


def test_interpolated_frames_are_close_to_the_true_ones() -> None:
    meter, shift = MotionMeter(100.0), 6.0
    before, after = 100 * wall(0), 100 * wall(shift)
    forward, backward = meter.flow_px(before, after), meter.flow_px(after, before)
    inside = np.s_[10:-10, 16:-16]
    times = []
    for t, found in interpolated(before, after, forward, backward, 3):
        true = 100 * wall(t * shift)
        mixed = (1 - t) * before + t * after
        times.append(t)
        wrong = np.sqrt(np.mean((found - true)[inside] ** 2))
        assert wrong < 0.1 * np.sqrt(np.mean((mixed - true)[inside] ** 2))
    assert times == [0.25, 0.5, 0.75]


@pytest.mark.parametrize(
    ("motion", "number"), [(0.0, 0), (0.5, 0), (0.6, 1), (1.0, 1), (4.0, 7), (1e6, 200)]
)
def test_interpolated_steps_are_half_a_pixel(motion: float, number: int) -> None:
    assert interpolation_count(motion, 0.5) == number
