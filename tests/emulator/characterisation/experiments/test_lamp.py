"""A lamp on the mains: rates and regularity of its events."""

import math
from dataclasses import replace

import pytest

from emulator import SensorConfig
from emulator.characterisation.experiments.lamp import measure, measure_lamp

CLEAN = replace(
    SensorConfig.noise_free(), theta_on=0.28, theta_off=0.35, theta_mismatch=0.0, follower_hz=0.0
)


def test_with_equal_rise_and_fall_the_thresholds_set_the_ratio() -> None:
    """θ_on·R_on = θ_off·R_off without leak and with hardly any refractory period."""
    config = replace(CLEAN, refractory_us=0)
    lamp = measure_lamp(config, chip_lux=20_000.0, swing=2.65, fall=0.5, seed=1)
    assert lamp.on_hz > 500.0
    assert 0.28 * lamp.on_hz == pytest.approx(0.35 * lamp.off_hz, rel=0.02)


def test_leak_is_the_difference_of_rises_and_falls() -> None:
    """A leak of 28 ln units a second, the drift of 100 ON events."""
    config = replace(CLEAN, refractory_us=0, leak_hz=100.0, leak_spread=0.0, leak_tail_fraction=0.0)
    lamp = measure_lamp(config, chip_lux=20_000.0, swing=2.65, fall=0.5, seed=1)
    assert 0.28 * lamp.on_hz - 0.35 * lamp.off_hz == pytest.approx(28.0, rel=0.1)


def test_a_sudden_fall_hides_in_the_refractory_period() -> None:
    config = replace(CLEAN, refractory_us=270)
    slow = measure_lamp(config, chip_lux=20_000.0, swing=2.65, fall=0.5, seed=1)
    sudden = measure_lamp(config, chip_lux=20_000.0, swing=2.65, fall=0.05, seed=1)
    assert 100.0 <= sudden.off_hz <= 210.0
    assert slow.off_hz > 2.0 * sudden.off_hz
    assert slow.on_variation is not None
    assert sudden.on_variation is not None
    assert sudden.on_variation < 0.5 < slow.on_variation


def test_a_steady_lamp_has_no_intervals() -> None:
    lamp = measure_lamp(CLEAN, chip_lux=20_000.0, swing=0.0, fall=0.5, seed=1)
    assert (lamp.on_hz, lamp.off_hz, lamp.on_variation) == (0.0, 0.0, None)


def test_section_of_the_default_sensor() -> None:
    section = measure(SensorConfig(), seed=1)
    assert len(section.quantities) == 6
    for row in section.quantities:
        assert row.measured is not None
        assert math.isfinite(row.measured)
        assert row.published is not None
