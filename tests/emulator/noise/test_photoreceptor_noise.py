import math
from dataclasses import replace

import numpy as np
import pytest

from emulator import SensorConfig
from emulator.noise.photoreceptor_noise import draw_dark_factors, noise_of

PER_HZ = 2e-6 * math.pi


def sigma(lux: float, *, follower_hz: float, limit_hz: float = 3000.0) -> float:
    """Return σ for σ0 = 0.07 and 100 Hz per lux."""
    opened = PER_HZ * 100.0 * lux
    follower_us = 1.0 / (PER_HZ * follower_hz) if follower_hz else 0.0
    return float(noise_of(0.07, min(opened, PER_HZ * limit_hz), opened, follower_us).sigma)


def test_noise_does_not_depend_on_the_light_while_the_bandwidth_grows_with_it() -> None:
    assert sigma(0.1, follower_hz=0.0) == pytest.approx(0.07)
    assert sigma(30.0, follower_hz=0.0) == pytest.approx(0.07)


def test_a_fixed_bandwidth_makes_the_variance_fall_as_the_light_grows() -> None:
    assert sigma(120.0, follower_hz=0.0) == pytest.approx(0.07 / 2.0)
    assert sigma(2.86, follower_hz=286.0) == pytest.approx(0.07 / math.sqrt(2.0))
    bright = sigma(1e4, follower_hz=286.0), sigma(4e4, follower_hz=286.0)
    assert bright[0] / bright[1] == pytest.approx(2.0)


def test_two_low_passes_add_their_time_constants_and_smooth_the_noise() -> None:
    noise = noise_of(0.07, 1 / 500.0, 1 / 500.0, 500.0)
    assert noise.per_tau == pytest.approx(1e-3)
    assert noise.smoothing == pytest.approx(0.8)
    assert noise_of(0.07, 1 / 500.0, 1 / 500.0, 0.0).smoothing == 0.0


def test_dark_currents_have_the_stated_median_and_spread() -> None:
    drawn = np.log(draw_dark_factors(SensorConfig(), np.random.default_rng(1)))
    assert np.median(drawn) == pytest.approx(0.0, abs=0.01)
    assert drawn.std() == pytest.approx(0.45, rel=0.02)
    even = replace(SensorConfig(), dark_current_spread=0.0)
    assert np.all(draw_dark_factors(even, np.random.default_rng(1)) == 1.0)
