"""Intervals: those of noise are nearly random, and those of leak are regular within a pixel."""

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
from tests.emulator.characterisation.plain_sensor import PLAIN, QUIET


def test_noise_has_irregular_intervals() -> None:
    """The variation of the polarities together exceeds 1: an event is often followed by another."""
    config = replace(QUIET, noise_sigma=0.08, theta_mismatch=0.0)
    found = measure_intervals(record_static(config, chip_lux=DIM_LUX, seed=1))
    assert found is not None
    assert 0.9 < found.pixel_variation < 1.5
    assert found.variation == pytest.approx(found.pixel_variation, rel=0.05)


def test_leak_is_periodic_within_a_pixel_and_varies_with_mismatch() -> None:
    found = measure_intervals(record_static(PLAIN, chip_lux=BRIGHT_LUX, seed=1))
    assert found is not None
    assert found.pixel_variation < 0.02
    assert found.variation == pytest.approx(0.035 / 0.18, rel=0.15)


def test_section_of_the_default_sensor() -> None:
    """Its noise makes the leak slightly irregular."""
    section = measure(SensorConfig(), seed=1)
    assert len(section.plots) == 2
    dim, dim_pixel, bright, bright_pixel = (row.measured for row in section.quantities)
    assert dim is not None
    assert dim_pixel is not None
    assert bright is not None
    assert bright_pixel is not None
    assert bright_pixel < 0.1 < 0.3 < bright
    assert dim > dim_pixel > bright_pixel


def test_a_sensor_without_events_has_no_intervals() -> None:
    assert measure_intervals(record_static(QUIET, chip_lux=BRIGHT_LUX, seed=1)) is None
    section = measure(QUIET, seed=1)
    assert [quantity.measured for quantity in section.quantities] == [None] * 4
    assert section.plots == []
