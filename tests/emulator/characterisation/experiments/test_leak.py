"""The leak against illuminance and temperature, found without the causes of events."""

from dataclasses import replace

import numpy as np
import pytest

from emulator import SensorConfig
from emulator.characterisation.experiments.leak import doubling_k, leak_line, measure, measure_leak
from tests.emulator.characterisation.plain_sensor import PLAIN


def test_the_line_through_rates_is_recovered() -> None:
    lux = np.array([1.0, 10.0, 100.0])
    assert leak_line(lux, 0.2 + 0.003 * lux) == pytest.approx((0.2, 0.003))
    assert leak_line(lux, [0.2, np.nan, np.nan]) == (None, None)


def test_the_doubling_temperature_is_recovered() -> None:
    celsius = np.array([10.0, 20.0, 50.0])
    assert doubling_k(celsius, 2.0 ** (celsius / 8.0)) == pytest.approx(8.0)
    assert doubling_k(celsius, [1.0, 1.0, 0.5]) is None
    assert doubling_k(celsius, [1.0, np.nan, np.nan]) is None


def test_the_leak_doubles_as_configured() -> None:
    config = replace(PLAIN, leak_doubling_k=9.0)
    warm, cool = (
        measure_leak(replace(config, temperature_c=c), chip_lux=30.0, seed=1).leak_hz
        for c in (52.0, 25.0)
    )
    assert warm is not None
    assert cool is not None
    assert warm / cool == pytest.approx(8.0, rel=0.02)


def test_noise_hides_the_leak_in_dim_light() -> None:
    assert measure_leak(SensorConfig(), chip_lux=0.1, seed=1).leak_hz is None


def test_the_section_recovers_leak_and_spread() -> None:
    config = replace(SensorConfig(), leak_hz=0.2, leak_hz_per_lux=1e-4)
    dark, _, slope, warming, spread, bright_spread = measure(config, seed=4).quantities
    assert dark.measured == pytest.approx(0.2, rel=0.08)
    assert slope.measured == pytest.approx(0.1, rel=0.08)
    assert warming.measured == pytest.approx(7.0, rel=0.03)
    for row in (spread, bright_spread):
        assert row.measured == pytest.approx(np.hypot(0.4, 0.024 / 0.28), rel=0.12)


def test_section_of_the_default_sensor() -> None:
    for row in measure(SensorConfig(), seed=1).quantities:
        assert row.measured is not None, row.name
