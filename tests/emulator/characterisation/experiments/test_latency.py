"""Latency depends on the photoreceptor, jitter on noise and mismatch."""

import math
from dataclasses import replace

import numpy as np
import pytest

from emulator import SensorConfig
from emulator.characterisation.experiments.latency import measure, measure_latency
from tests.emulator.characterisation.plain_sensor import QUIET


def test_latency_is_proportional_to_the_time_constant() -> None:
    config = replace(QUIET, bandwidth_limit_hz=1e6)
    slow, fast = (measure_latency(config, chip_lux=lux, seed=1) for lux in (1.0, 10.0))
    assert slow is not None
    assert fast is not None
    assert slow.median_us / fast.median_us == pytest.approx(10.01 / 1.01, rel=0.15)
    assert slow.response_share == fast.response_share == 1.0


def test_a_step_below_the_threshold_has_no_latency() -> None:
    config = replace(SensorConfig.noise_free(), theta_on=2.0)
    assert measure_latency(config, chip_lux=10.0, seed=1) is None


def test_equal_pixels_without_noise_have_no_jitter_between_them() -> None:
    config = replace(QUIET, theta_mismatch=0.0)
    found = measure_latency(config, chip_lux=100.0, seed=1)
    assert found is not None
    assert found.pixel_jitter_us == pytest.approx(found.jitter_us, rel=0.05)


_FOLLOWER_US = -1e6 / (2.0 * math.pi * 286.0) * math.log(1.0 - 0.28 / math.log(2.0))
"""Time in which the follower passes the threshold after a step of 2 to 1 [µs]. The photoreceptor
delays it, and so does the memory, which is not always at the level before the step."""


def test_section_of_the_default_sensor() -> None:
    section = measure(SensorConfig(), seed=1)
    best = section.quantities[0].measured
    assert best is not None
    assert 1.2 * _FOLLOWER_US < best < 2.4 * _FOLLOWER_US
    (plot,) = section.plots
    latency = plot.series[0].y
    assert np.isfinite(latency[1:]).all()
    assert latency[1] > latency[2] > latency[4]
