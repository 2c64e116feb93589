"""Motion between frames, and what lies between them."""

from typing import Any

import numpy as np
import pytest

from scenarios.emulate.motion import MotionMeter, between, pictures_between
from tests.scenarios.emulate.moving import bar, grating, wall


@pytest.mark.parametrize("shift", [0.0, 0.5, 3.0, 8.0])
def test_the_motion_of_a_wall_is_its_shift(shift: float) -> None:
    meter = MotionMeter(100.0)
    before, after = 100 * wall(0), 100 * wall(shift)
    flow = meter.flow_px(before, after)
    assert np.median(flow[20:-20, 20:-20, 0]) == pytest.approx(shift, abs=0.1)
    assert meter.motion_px(before, after, flow) == pytest.approx(shift, abs=0.1 + 0.1 * shift)


@pytest.mark.parametrize("drawn", [bar, grating])
def test_flow_along_a_stripe_is_no_motion(drawn: Any) -> None:
    """2 px a frame; of the motion along a stripe, nothing can be seen (the aperture problem)."""
    meter, found, longest = MotionMeter(100.0), [], 0.0
    for k in range(12):
        before, after = (100 * drawn(2.0 * frame, rows=260, columns=346) for frame in (k, k + 1))
        flow = meter.flow_px(before, after)
        longest = max(longest, float(np.hypot(*flow.reshape(-1, 2).T).max()))
        found.append(meter.motion_px(before, after, flow))
    assert longest > 20.0  # the flow is as wrong as it was found to be
    assert max(found) == pytest.approx(2.0, abs=0.2)
    assert pictures_between(max(found), 0.5) < 5


def test_a_flicker_is_no_motion() -> None:
    meter, dark = MotionMeter(100.0), np.full((130, 173), 20.0, np.float32)
    assert meter.motion_px(dark, 2 * dark, meter.flow_px(dark, 2 * dark)) == 0.0


def test_a_small_thing_before_a_still_wall_is_seen() -> None:
    """0.4 % of the picture moves by 4 px; the rest does not."""
    meter, still = MotionMeter(100.0), 100 * wall(0)
    before, after = still.copy(), still.copy()
    thing = 100 * wall(0)[:10, :9] * 0.3
    before[60:70, 60:69] = thing
    after[60:70, 64:73] = thing
    found = meter.motion_px(before, after, meter.flow_px(before, after))
    assert 2.0 < found < 8.0


def test_pictures_between_are_what_would_have_been_seen() -> None:
    meter, shift = MotionMeter(100.0), 6.0
    before, after = 100 * wall(0), 100 * wall(shift)
    forth, back = meter.flow_px(before, after), meter.flow_px(after, before)
    inside = np.s_[10:-10, 16:-16]
    times = []
    for t, found in between(before, after, forth, back, 3):
        true = 100 * wall(t * shift)
        mixed = (1 - t) * before + t * after
        times.append(t)
        wrong = np.sqrt(np.mean((found - true)[inside] ** 2))
        assert wrong < 0.1 * np.sqrt(np.mean((mixed - true)[inside] ** 2))
    assert times == [0.25, 0.5, 0.75]


@pytest.mark.parametrize(
    ("motion", "number"), [(0.0, 0), (0.5, 0), (0.6, 1), (1.0, 1), (4.0, 7), (1e6, 200)]
)
def test_steps_are_half_a_pixel(motion: float, number: int) -> None:
    assert pictures_between(motion, 0.5) == number
