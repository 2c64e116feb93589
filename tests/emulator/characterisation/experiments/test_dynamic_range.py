"""The dynamic range is limited by the dark current and by noise."""

from dataclasses import replace

import numpy as np
import pytest

from emulator import SensorConfig
from emulator.characterisation.experiments.dynamic_range import (
    dynamic_range_db,
    measure,
    responding_share,
)
from tests.emulator.characterisation.plain_sensor import QUIET


def test_the_range_is_interpolated_between_illuminances() -> None:
    lux = np.array([1.0, 10.0, 100.0, 1000.0])
    assert dynamic_range_db(lux, np.array([0.0, 1.0, 1.0, 1.0])) == pytest.approx(50.0)
    assert dynamic_range_db(lux, np.array([0.0, 1.0, 1.0, 0.0])) == pytest.approx(40.0)
    assert dynamic_range_db(lux, np.ones(4)) == pytest.approx(60.0)
    assert dynamic_range_db(lux, np.full(4, 0.4)) is None


def test_noise_free_pixels_respond_once_the_bar_exceeds_their_threshold() -> None:
    config = replace(QUIET, theta_mismatch=0.0)
    edge = config.dark_lux * np.expm1(0.22) / (1.0 - 0.2 * np.exp(0.22))
    assert responding_share(config, chip_lux=0.95 * edge, seed=1) == 0.0
    assert responding_share(config, chip_lux=1.05 * edge, seed=1) == 1.0


def test_ten_times_the_dark_current_costs_20_db() -> None:
    config = QUIET
    dark, darker = (
        measure(replace(config, dark_lux=lux), seed=1).quantities[0].measured for lux in (0.1, 0.01)
    )
    assert dark is not None
    assert darker is not None
    assert darker - dark == pytest.approx(20.0, abs=0.5)


def test_section_of_the_default_sensor() -> None:
    section = measure(SensorConfig(), seed=1)
    assert section.quantities[0].measured == pytest.approx(115.0, abs=8.0)
