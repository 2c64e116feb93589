"""Rates by the equations of the model, against those of the emulator."""

from dataclasses import replace

import numpy as np
import pytest

from emulator import SensorConfig
from emulator.characterisation.bench import (
    bench_sensor,
    chip_luminance,
    column_frame,
    event_counts,
    record,
    static_samples,
)
from emulator.characterisation.settled_rates import settled_rates

EQUAL = SensorConfig(leak_spread=0.0, leak_tail_fraction=0.0)
LUX = np.array([0.0, 0.1, 1.0, 10.0])
COLUMNS, ROWS, SECONDS = 48, 64, 12.0
SENSORS = {
    "default": replace(EQUAL, noise_sigma=0.1),
    "fast": replace(EQUAL, noise_sigma=0.08, theta_on=0.4, follower_hz=0.0, refractory_us=150),
}


@pytest.mark.parametrize("name", SENSORS)
def test_rates_are_those_of_the_emulator(name: str) -> None:
    config = SENSORS[name]
    bench = bench_sensor(config, width=LUX.size * COLUMNS, height=ROWS)
    frame = column_frame(bench, chip_luminance(bench, np.repeat(LUX, COLUMNS)))
    recording = record(bench, static_samples(frame, duration_s=SECONDS), seed=4)
    expected = settled_rates(config, LUX)
    for k, polarity in enumerate((True, False)):
        events = recording.events[recording.events["p"] == polarity]
        counts = event_counts(events, recording.shape).reshape(ROWS, LUX.size, COLUMNS)
        measured = counts.sum(axis=(0, 2)) / (ROWS * COLUMNS * SECONDS)
        np.testing.assert_allclose(measured, expected[:, k], rtol=0.3, atol=0.01)


def test_without_noise_leak_alone_gives_events() -> None:
    config = replace(EQUAL, noise_sigma=0.0, leak_hz=0.2)
    rates = settled_rates(config, LUX)
    np.testing.assert_allclose(rates[:, 0], 0.2 + 2.6e-5 * LUX, rtol=0.01)
    np.testing.assert_array_equal(rates[:, 1], 0.0)


def test_leak_is_the_difference_of_what_the_polarities_change() -> None:
    """Without a refractory period, θ_on·R_on − θ_off·R_off is the leak, whatever the noise."""
    config = replace(EQUAL, noise_sigma=0.09, refractory_us=0, theta_mismatch=0.0)
    on, off = settled_rates(config, [0.3])[0]
    drift = config.theta_on * (config.leak_hz + config.leak_hz_per_lux * 0.3)
    assert config.theta_on * on - config.theta_off * off == pytest.approx(drift, rel=0.1, abs=0.02)
