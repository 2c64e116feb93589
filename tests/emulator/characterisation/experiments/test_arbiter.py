"""What the bus carries, delays and loses."""

from dataclasses import replace

import numpy as np
import pytest

from emulator import ReadoutConfig, SensorConfig, preset
from emulator.characterisation.experiments.arbiter import (
    Load,
    delays_us,
    measure,
    measure_load,
    rate_that_loses,
    rates_hz,
)
from flybench.events import EVENT_DTYPE


def test_delays_go_from_the_event_that_waited() -> None:
    made = np.array(
        [(10, 1, 0, 1), (12, 1, 0, 1), (14, 0, 0, 0), (20, 1, 0, 1), (30, 1, 0, 0)], EVENT_DTYPE
    )
    passed = np.array([(14, 0, 0, 0), (16, 1, 0, 1), (25, 1, 0, 1), (30, 1, 0, 0)], EVENT_DTYPE)
    found = delays_us(made, passed, width=2, reset_us=3)
    assert found.tolist() == [0, 6, 5, 0]


def test_events_of_one_microsecond_are_not_taken_for_late() -> None:
    made = np.array([(10, 0, 0, 1), (10, 0, 0, 1), (25, 0, 0, 1)], EVENT_DTYPE)
    assert set(delays_us(made, made, width=1, reset_us=1).tolist()) == {0}


def test_a_bus_without_limits_delays_nothing() -> None:
    load = measure_load(SensorConfig.ideal(), flicker_hz=100.0, seed=1)
    assert load is not None
    assert load.in_hz == load.out_hz
    assert load.slowest_us == 0.0


def test_a_greatest_rate_takes_a_loss_to_show() -> None:
    calm, crowded = Load(1e6, 1e6, 0.0, 0.0), Load(1e7, 8e6, 90.0, 200.0)
    assert rate_that_loses([calm, calm], 0.01) is None
    losing_hz = rate_that_loses([calm, crowded], 0.1)
    assert losing_hz == pytest.approx(10**6.5)


def test_a_calm_bus_passes_everything_on_at_once() -> None:
    load = measure_load(SensorConfig(), flicker_hz=2.0, seed=1)
    assert load is not None
    assert load.out_hz == load.in_hz
    assert load.slowest_us == 0.0


@pytest.mark.parametrize("limit_hz", [2e6, 12e6])
def test_a_crowded_bus_carries_its_limit_and_no_more(limit_hz: float) -> None:
    config = replace(SensorConfig(), readout=ReadoutConfig(limit_hz=limit_hz))
    load = measure_load(config, flicker_hz=limit_hz / 2e4, seed=1)
    assert load is not None
    assert load.in_hz > 2.0 * limit_hz
    assert 0.9 * limit_hz < load.out_hz < limit_hz
    assert load.mean_us > 10.0


@pytest.mark.parametrize(
    ("config", "seed"),
    [(preset("dvs128"), 3), (SensorConfig(readout=ReadoutConfig(limit_hz=2e6)), 0)],
)
def test_the_greatest_rate_of_the_sheet_is_below_what_the_bus_carries(
    config: SensorConfig, seed: int
) -> None:
    most = measure(config, seed=seed).figures["greatest rate out"].measured
    assert most is not None
    assert 0.97 * config.readout.limit_hz < 1e6 * most < config.readout.limit_hz


def test_rates_leave_the_last_row_out() -> None:
    row = [(30, x, 0, 1) for x in range(5)]
    made = np.array([(10, 0, 0, 1), (12, 0, 1, 1), (20, 0, 2, 1), *row], EVENT_DTYPE)
    assert rates_hz(made, made, from_us=11) == pytest.approx((2e6 / 18, 2e6 / 18))
    assert rates_hz(made, made[1:], from_us=0) == pytest.approx((2e6 / 18, 2e6 / 18))
    assert rates_hz(made, made[:4], from_us=30) is None


def test_a_bus_too_slow_for_the_slowest_flicker_has_a_greatest_rate_all_the_same() -> None:
    figures = measure(SensorConfig(readout=ReadoutConfig(limit_hz=5e4)), seed=1).figures
    assert figures["greatest rate out"].measured == pytest.approx(0.05 * 128 / 129, rel=0.01)
    assert figures["rate in that loses 1 %"].note == "the slowest flicker loses more"
    assert figures["mean delay at half the greatest rate"].measured is None


def test_latency_adds_to_every_delay() -> None:
    config = replace(SensorConfig(), readout=ReadoutConfig(latency_us=7))
    load = measure_load(config, flicker_hz=2.0, seed=1)
    assert load is not None
    assert load.mean_us == pytest.approx(7.0, abs=0.05)


def test_section_of_the_default_sensor() -> None:
    most, losing, busy, slowest = measure(SensorConfig(), seed=1).quantities
    assert most.measured == pytest.approx(12.0, rel=0.05)
    assert losing.measured is not None
    assert 8.0 < losing.measured < 12.0
    assert busy.measured is not None
    assert 0.1 < busy.measured < 5.0
    assert most.published is not None
    assert slowest.measured is not None
    assert slowest.measured > 100.0


def test_a_silent_sensor_has_no_readout_to_measure() -> None:
    config = replace(SensorConfig.noise_free(), theta_on=5.0, theta_off=5.0)
    assert measure_load(config, flicker_hz=10.0, seed=1) is None
