"""Shot noise is a Poisson process, and leak is periodic."""

from dataclasses import replace

import pytest

from emulator import SensorConfig
from emulator.characterisation.experiments.background import record_static
from emulator.characterisation.experiments.intervals import (
    BRIGHT_LUX,
    DIM_LUX,
    measure,
    measure_intervals,
)


def test_shot_noise_has_the_intervals_of_a_poisson_process() -> None:
    found = measure_intervals(record_static(SensorConfig(), chip_lux=DIM_LUX, seed=1))
    assert found is not None
    assert found.variation == pytest.approx(1.0, abs=0.02)
    assert found.interval_s.mean() == pytest.approx(1.0 / 9.7, rel=0.03)


def test_leak_is_periodic_within_a_pixel_and_varies_with_mismatch() -> None:
    found = measure_intervals(record_static(SensorConfig(), chip_lux=BRIGHT_LUX, seed=1))
    assert found is not None
    assert found.pixel_variation < 0.02
    assert found.variation == pytest.approx(0.035 / 0.18, rel=0.15)


def test_a_sensor_without_events_has_no_intervals() -> None:
    config = replace(SensorConfig.noise_free())
    assert measure_intervals(record_static(config, chip_lux=BRIGHT_LUX, seed=1)) is None
    section = measure(config, seed=1)
    assert [quantity.measured for quantity in section.quantities] == [None] * 4
    assert section.plots == []
