"""The cutoff is recovered from events per cycle, and rises with illuminance."""

from dataclasses import replace

import numpy as np
import pytest

from emulator import SensorConfig
from emulator.characterisation.bench import log_spaced
from emulator.characterisation.experiments.bandwidth import (
    LEAST_SWING,
    Calibration,
    calibrate,
    measure,
    measure_response,
)
from tests.emulator.characterisation.plain_sensor import QUIET


def test_the_cutoff_rises_with_illuminance_to_a_limit() -> None:
    config = replace(QUIET, bandwidth_limit_hz=800.0)
    responses = measure_response(
        config,
        calibrate(config, seed=1),
        chip_lux=[0.4, 2.0, 500.0],
        frequency_hz=log_spaced(10.0, 4000.0, 5),
        seed=1,
    )
    cutoffs = [response.cutoff_hz for response in responses]
    assert cutoffs == pytest.approx([41.0, 201.0, 800.0], rel=0.1)


def test_the_flicker_is_stronger_for_a_high_threshold() -> None:
    config = replace(QUIET, theta_on=0.5, bandwidth_limit_hz=800.0)
    calibration = calibrate(config, seed=1)
    assert calibration.swing == pytest.approx(2.75)
    (response,) = measure_response(
        config, calibration, chip_lux=[500.0], frequency_hz=log_spaced(10.0, 4000.0, 5), seed=1
    )
    assert response.cutoff_hz == pytest.approx(800.0, rel=0.1)


def test_noise_is_counted_separately_and_prevents_a_fit() -> None:
    config = replace(SensorConfig(), noise_sigma=0.15)
    dim, bright = measure_response(
        config,
        calibrate(config, seed=1),
        chip_lux=[0.02, 500.0],
        frequency_hz=log_spaced(1.0, 1000.0, 3),
        seed=1,
    )
    assert dim.cutoff_hz is None
    assert dim.noise_per_cycle[0] > 1.0
    assert bright.noise_per_cycle.max() < 0.05


def test_the_calibration_counts_thresholds() -> None:
    config = replace(QUIET, theta_mismatch=0.0, refractory_us=0)
    calibration = calibrate(config, seed=1)
    steps = calibration.amplitude / 0.18
    assert np.all(calibration.events <= steps + 1e-9)
    assert np.all(calibration.events >= np.floor(steps) - 2.0)


def test_the_fit_recovers_share_and_cutoff() -> None:
    amplitude = np.linspace(0.0, 1.2 * LEAST_SWING, 50)
    calibration = Calibration(amplitude, np.maximum(5.0 * amplitude - 0.5, 0.0), 3.0)
    frequency = log_spaced(1.0, 1000.0, 6)
    events = calibration.model(frequency, 0.9, 70.0)
    assert calibration.fit(frequency, events, frequency > 0) == pytest.approx((0.9, 70.0), rel=0.01)
    assert calibration.fit(frequency, events, frequency < 3) is None


def test_section_of_the_default_sensor() -> None:
    section = measure(SensorConfig(), seed=2)
    at_1_klux, bright = section.quantities
    assert at_1_klux.measured == pytest.approx(280.0, rel=0.2)  # some of its events count as noise
    assert bright.measured == pytest.approx(286.0, rel=0.12)
