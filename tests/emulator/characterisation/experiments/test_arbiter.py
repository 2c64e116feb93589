"""The readout: rates, delays and losses."""

from dataclasses import replace

import numpy as np
import pytest

from emulator import ReadoutConfig, SensorConfig, preset
from emulator.characterisation.experiments.arbiter import (
    Load,
    delays_us,
    measure,
    measure_load,
    rate_at_loss,
    rates_hz,
)
from flybench.events import EVENT_DTYPE


def test_a_delay_is_measured_from_the_waiting_event() -> None:
    generated = np.array(
        [(10, 1, 0, 1), (12, 1, 0, 1), (14, 0, 0, 0), (20, 1, 0, 1), (30, 1, 0, 0)], EVENT_DTYPE
    )
    read_out = np.array([(14, 0, 0, 0), (16, 1, 0, 1), (25, 1, 0, 1), (30, 1, 0, 0)], EVENT_DTYPE)
    found = delays_us(generated, read_out, width=2, reset_us=3)
    assert found.tolist() == [0, 6, 5, 0]


def test_events_in_the_same_microsecond_are_not_late() -> None:
    generated = np.array([(10, 0, 0, 1), (10, 0, 0, 1), (25, 0, 0, 1)], EVENT_DTYPE)
    assert set(delays_us(generated, generated, width=1, reset_us=1).tolist()) == {0}


def test_a_bus_without_limits_delays_nothing() -> None:
    load = measure_load(SensorConfig.ideal(), flicker_hz=100.0, seed=1)
    assert load is not None
    assert load.in_hz == load.out_hz
    assert load.percentile_99_us == 0.0


def test_a_rate_at_a_loss_needs_a_loss() -> None:
    calm, crowded = Load(1e6, 1e6, 0.0, 0.0), Load(1e7, 8e6, 90.0, 200.0)
    assert rate_at_loss([calm, calm], 0.01) is None
    loss_hz = rate_at_loss([calm, crowded], 0.1)
    assert loss_hz == pytest.approx(10**6.5)


def test_a_lightly_loaded_bus_reads_out_every_event_at_once() -> None:
    load = measure_load(SensorConfig(), flicker_hz=2.0, seed=1)
    assert load is not None
    assert load.out_hz == load.in_hz
    assert load.percentile_99_us == 0.0


@pytest.mark.parametrize("limit_hz", [2e6, 12e6])
def test_an_overloaded_bus_carries_its_limit(limit_hz: float) -> None:
    config = replace(SensorConfig(), readout=ReadoutConfig(limit_hz=limit_hz))
    load = measure_load(config, flicker_hz=limit_hz / 2e4, seed=1)
    assert load is not None
    assert load.in_hz > 1.5 * limit_hz
    assert 0.9 * limit_hz < load.out_hz < limit_hz
    assert load.mean_us > 10.0


@pytest.mark.parametrize(
    ("config", "seed"),
    [(preset("dvs128"), 3), (SensorConfig(readout=ReadoutConfig(limit_hz=2e6)), 0)],
)
def test_the_highest_output_rate_is_below_the_limit_of_the_bus(
    config: SensorConfig, seed: int
) -> None:
    most = measure(config, seed=seed).figures["highest output rate"].measured
    assert most is not None
    assert 0.97 * config.readout.limit_hz < 1e6 * most < config.readout.limit_hz


def test_rates_do_not_count_the_last_row() -> None:
    row = [(30, x, 0, 1) for x in range(5)]
    generated = np.array([(10, 0, 0, 1), (12, 0, 1, 1), (20, 0, 2, 1), *row], EVENT_DTYPE)
    assert rates_hz(generated, generated, from_us=11) == pytest.approx((2e6 / 18, 2e6 / 18))
    assert rates_hz(generated, generated[1:], from_us=0) == pytest.approx((2e6 / 18, 2e6 / 18))
    assert rates_hz(generated, generated[:4], from_us=30) is None


def test_a_bus_that_is_always_overloaded_has_a_highest_rate() -> None:
    figures = measure(SensorConfig(readout=ReadoutConfig(limit_hz=5e4)), seed=1).figures
    assert figures["highest output rate"].measured == pytest.approx(0.05 * 96 / 98, rel=0.01)
    assert figures["input rate with a loss of 1 %"].note == "the slowest flicker loses more"
    assert figures["mean delay at half the highest rate"].measured is None


def test_the_readout_latency_adds_to_every_delay() -> None:
    config = replace(SensorConfig(), readout=ReadoutConfig(latency_us=7))
    load = measure_load(config, flicker_hz=2.0, seed=1)
    assert load is not None
    assert load.mean_us == pytest.approx(7.0, abs=0.05)


def test_section_of_the_default_sensor() -> None:
    most, lossy, busy, percentile_99 = measure(SensorConfig(), seed=1).quantities
    assert most.measured == pytest.approx(12.0, rel=0.05)
    assert lossy.measured is not None
    assert 8.0 < lossy.measured < 12.0
    assert busy.measured is not None
    assert 5.0 < busy.measured < 30.0
    assert most.published is not None
    assert percentile_99.measured is not None
    assert percentile_99.measured > 100.0


def test_a_sensor_without_events_has_no_load() -> None:
    config = replace(SensorConfig.noise_free(), theta_on=5.0, theta_off=5.0)
    assert measure_load(config, flicker_hz=10.0, seed=1) is None
