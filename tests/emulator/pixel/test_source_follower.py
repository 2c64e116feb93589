import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from emulator import ApsConfig
from emulator.pixel.change_detector import NEVER_US
from emulator.pixel.source_follower import (
    SecondOrderCourse,
    amplitudes,
    first_second_order_crossing,
    second_lag_after,
    separated,
    value_at,
)
from emulator.readout.config import UNLIMITED
from tests.emulator.stimuli import (
    log_ramp,
    luminance_for_lux,
    moving_texture,
    noise_free_config,
    run_sensor,
    uniform_frame,
)

ON, OFF = 0.18, 0.22

given_pixel = given(
    lag=st.floats(-2, 2),
    second_lag=st.floats(-1, 1),
    slope=st.floats(-3e-3, 3e-3),
    tau=st.floats(20, 1e4),
    follower=st.floats(20, 1e4),
    span=st.floats(1, 5000),
)


@settings(max_examples=50, deadline=None)
@given_pixel
def test_the_closed_form_solves_the_differential_equations(
    lag: float, second_lag: float, slope: float, tau: float, follower: float, span: float
) -> None:
    assume(abs(follower / tau - 1.0) > 0.01)
    n, w = 4000, 0.0
    first, second, dt = lag, second_lag, span / n

    def rates(first: float, second: float) -> tuple[float, float]:
        return slope - first / tau, first / tau - second / follower

    for _ in range(n):
        begin = rates(first, second)
        half = first + 0.5 * dt * begin[0], second + 0.5 * dt * begin[1]
        middle = rates(*half)
        w += dt * half[1] / follower
        first, second = first + dt * middle[0], second + dt * middle[1]
    assert second_lag_after(lag, second_lag, slope, tau, follower, span) == pytest.approx(
        second, abs=2e-3
    )
    a, b = amplitudes(lag, second_lag, slope, tau, follower)
    course = SecondOrderCourse(0.0, slope, a, b, tau, follower)
    assert value_at(course, span) == pytest.approx(w, abs=5e-3)


@given_pixel
def test_the_earliest_crossing_is_found(
    lag: float, second_lag: float, slope: float, tau: float, follower: float, span: float
) -> None:
    follower = separated(tau, follower)
    a, b = amplitudes(lag, second_lag, slope, tau, follower)
    s = np.linspace(0.0, span, 20_001)
    d = slope * s + a * (1 - np.exp(-s / tau)) + b * (1 - np.exp(-s / follower))
    outside = np.flatnonzero((d >= ON) | (d <= -OFF))
    assume(abs(d.max() - ON) > 1e-5)
    assume(abs(d.min() + OFF) > 1e-5)
    course = SecondOrderCourse(0.0, slope, a, b, tau, follower)
    found, on = first_second_order_crossing(course, span, ON, OFF)
    if outside.size == 0:
        assert found == NEVER_US
        return
    first = int(outside[0])
    assert s[first - 1] - 1e-6 <= found <= s[first] + 1e-6
    assert on == (d[first] >= ON)


def test_equal_time_constants_give_the_limit() -> None:
    """The limit is m(0)·e + (l(0)·s/τ)·e, with e = exp(−s/τ)."""
    expected = (0.3 + 0.7 * 2.0) * math.exp(-2.0)
    assert second_lag_after(0.7, 0.3, 0.0, 100.0, 100.0, 200.0) == pytest.approx(expected, rel=2e-3)


def test_a_ramp_is_delayed_by_both_time_constants() -> None:
    config = noise_free_config(refractory_us=0, follower_hz=590.0, readout=UNLIMITED)
    samples = log_ramp(config, start=300.0, rate_per_s=40.0, times_us=range(0, 100_001, 1000))
    events, _ = run_sensor(config, samples)
    mine = events["t"][(events["x"] == 1) & (events["y"] == 1)]
    delay_us = 1e6 / (2 * math.pi) * (1 / config.bandwidth_limit_hz + 1 / 590.0)
    expected = 0.18 / 40.0 * 1e6 * np.arange(1, mine.size + 1) + delay_us
    assert mine.size >= 21
    assert np.abs(mine - expected)[2:].max() <= 3


@pytest.mark.parametrize("step_us", [200, 5000])
def test_the_response_to_a_luminance_step_is_the_sum_of_two_exponentials(step_us: int) -> None:
    config = noise_free_config(refractory_us=0, dark_lux=1e-6, follower_hz=300.0, readout=UNLIMITED)
    low, high = (uniform_frame(luminance_for_lux(e, config), config) for e in (1.0 / math.e, 1.0))
    samples = [(0, low), (1, high), *((1 + t, high) for t in range(step_us, 20_001, step_us))]
    events, _ = run_sensor(config, samples)
    mine = events["t"][(events["x"] == 0) & (events["y"] == 0)]
    tau, slow = (1e6 / (2 * math.pi * hz) for hz in (config.bandwidth_hz_per_lux, 300.0))
    s = np.arange(30_000.0)
    reached = 1 - (tau * np.exp(-s / tau) - slow * np.exp(-s / slow)) / (tau - slow)
    expected = [1 + int(np.argmax(reached >= config.theta_on * k)) for k in range(1, 6)]
    assert mine.size == 5
    assert np.abs(mine - expected).max() <= 3


def test_a_fast_follower_changes_almost_nothing() -> None:
    plain, _ = run_sensor(noise_free_config(), moving_texture(60))
    fast, _ = run_sensor(noise_free_config(follower_hz=1e6), moving_texture(60))
    assert plain.size > 400
    assert abs(fast.size - plain.size) <= 0.01 * plain.size


def test_a_still_scene_gives_no_events_and_threads_change_none() -> None:
    config = noise_free_config(
        follower_hz=590.0, aps=ApsConfig(noise=False, period_min_us=10_000_000)
    )
    frame = uniform_frame(1.0, config)
    static = [(0, frame), (10**6, frame), (10**9, frame)]
    assert run_sensor(config, static)[0].size == 0
    samples = list(moving_texture(40))
    one = run_sensor(config, samples)[0]
    two = run_sensor(config, samples, threads=2)[0]
    assert one.size > 200
    assert one.tobytes() == two.tobytes()
