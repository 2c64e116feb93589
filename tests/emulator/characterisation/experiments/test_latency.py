"""Latency depends on the photoreceptor, jitter on noise and mismatch."""

from dataclasses import replace

import pytest

from emulator import SensorConfig
from emulator.characterisation.experiments.latency import measure, measure_latency


def test_latency_is_proportional_to_the_time_constant() -> None:
    config = replace(SensorConfig.noise_free(), bandwidth_limit_hz=1e6)
    slow, fast = (measure_latency(config, chip_lux=lux, seed=1) for lux in (1.0, 10.0))
    assert slow is not None
    assert fast is not None
    assert slow.median_us / fast.median_us == pytest.approx(10.01 / 1.01, rel=0.15)
    assert slow.response_share == fast.response_share == 1.0


def test_a_step_below_the_threshold_has_no_latency() -> None:
    config = replace(SensorConfig.noise_free(), theta_on=2.0)
    assert measure_latency(config, chip_lux=10.0, seed=1) is None


def test_equal_pixels_without_noise_have_no_jitter_between_them() -> None:
    config = replace(SensorConfig.noise_free(), theta_mismatch=0.0)
    found = measure_latency(config, chip_lux=100.0, seed=1)
    assert found is not None
    assert found.pixel_jitter_us == pytest.approx(found.jitter_us, rel=0.05)


def test_section_of_the_default_sensor() -> None:
    section = measure(SensorConfig(), seed=1)
    best = section.quantities[0].measured
    assert best is not None
    assert 10.0 < best < 60.0
    (plot,) = section.plots
    latency = plot.series[0].y
    assert latency[0] > latency[2] > latency[4]
