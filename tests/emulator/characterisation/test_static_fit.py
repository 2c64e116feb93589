"""Parameters of a sensor, estimated from a static recording to within 10 %."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from emulator.pixel.noise import SHOT_LUX, SHOT_OFF_HZ, SHOT_ON_PER_OFF

from emulator import FitError, SensorConfig
from emulator.characterisation.bench import (
    Recording,
    bench_sensor,
    chip_luminance,
    record,
    static_samples,
    uniform_frame,
)
from emulator.characterisation.static_fit import StaticFit, fit_static
from flybench.errors import EventError
from flybench.events import EVENT_DTYPE, empty_events

SIDE_PX = 32
DRIFT_PER_S = 0.018
"""Drift of the memorised value in the dark, independent of the threshold [ln units/s]."""


def expected_shot_off_hz(lux: float, dark_lux: float) -> float:
    low, high = (np.log(x + dark_lux) for x in SHOT_LUX)
    power = np.log(SHOT_OFF_HZ[1] / SHOT_OFF_HZ[0]) / (high - low)
    return float(SHOT_OFF_HZ[0] * np.exp(power * (np.log(lux + dark_lux) - low)))


def recording_of(config: SensorConfig, *, lux: float, duration_s: float) -> Recording:
    sensor = bench_sensor(config, width=SIDE_PX, height=SIDE_PX)
    luminance = uniform_frame(sensor, chip_luminance(sensor, lux))
    return record(sensor, static_samples(luminance, duration_s=duration_s), seed=7)


def fit(recording: Recording, drift_per_s: float | None = None) -> StaticFit:
    return fit_static(
        recording.events,
        width=SIDE_PX,
        height=SIDE_PX,
        end_us=recording.duration_us,
        leak_drift_per_s=drift_per_s,
    )


@pytest.mark.parametrize("theta_on", [0.12, 0.18, 0.3])
@pytest.mark.parametrize("lux", [20.0, 300.0])
def test_threshold_leak_and_shot_noise_are_recovered(theta_on: float, lux: float) -> None:
    config = replace(
        SensorConfig(),
        theta_on=theta_on,
        theta_mismatch=0.025,
        leak_hz=DRIFT_PER_S / theta_on,
        leak_hz_per_lux=0.0,
        shot_noise_scale=3.0,
    )
    found = fit(recording_of(config, lux=lux, duration_s=400.0), DRIFT_PER_S)
    shot_off_hz = 3.0 * expected_shot_off_hz(lux, config.dark_lux)
    assert found.theta_on == pytest.approx(theta_on, rel=0.1)
    assert found.theta_mismatch == pytest.approx(0.025, rel=0.1)
    assert found.leak_hz == pytest.approx(DRIFT_PER_S / theta_on, rel=0.1)
    assert found.shot_off_hz == pytest.approx(shot_off_hz, rel=0.1)
    assert found.shot_on_hz == pytest.approx(SHOT_ON_PER_OFF * shot_off_hz, rel=0.1)


@pytest.mark.parametrize("lux", [0.1, 30.0])
def test_a_static_recording_does_not_depend_on_the_off_threshold(lux: float) -> None:
    """So no fit can recover it; `fit_ramps` recovers it from a modulation."""
    low, high, other = (
        recording_of(config, lux=lux, duration_s=20.0)
        for config in (
            SensorConfig(theta_off=0.12),
            SensorConfig(theta_off=0.4),
            SensorConfig(theta_on=0.19),
        )
    )
    assert low.events.size > 1000
    assert low.events.tobytes() == high.events.tobytes()
    assert low.events.tobytes() != other.events.tobytes()


def test_in_dim_light_only_shot_noise_is_found() -> None:
    found = fit(recording_of(SensorConfig(), lux=0.1, duration_s=20.0), DRIFT_PER_S)
    assert found.shot_off_hz == pytest.approx(4.2, rel=0.05)
    assert found.shot_on_hz == pytest.approx(5.5, rel=0.05)
    assert found.leak_hz is None
    assert found.theta_on is None
    assert found.relative_mismatch is None


def test_without_the_drift_the_mismatch_is_relative() -> None:
    found = fit(recording_of(SensorConfig(), lux=1000.0, duration_s=200.0))
    assert found.theta_on is None
    assert found.relative_mismatch == pytest.approx(0.035 / 0.18, rel=0.1)


def test_hot_pixels_are_left_out() -> None:
    config = replace(SensorConfig(), hot_fraction=0.01)
    found = fit(recording_of(config, lux=100.0, duration_s=100.0), DRIFT_PER_S)
    assert 0.004 < found.hot_share < 0.02
    assert found.theta_on == pytest.approx(0.18, rel=0.1)
    assert found.shot_on_hz < 0.01


def test_the_rate_of_rare_events_is_not_overestimated() -> None:
    rng = np.random.default_rng(2)
    pixels, rate_hz, end_s = 10_000, 0.05, 20.0
    n = rng.poisson(pixels * rate_hz * end_s)
    events = np.zeros(n, EVENT_DTYPE)
    events["t"] = np.sort(rng.uniform(0.0, end_s * 1e6, n)).astype(int)
    events["x"], events["y"] = rng.integers(0, 100, (2, n))
    found = fit_static(events, width=100, height=100, end_us=round(end_s * 1e6))
    assert found.shot_off_hz == pytest.approx(rate_hz, rel=0.05)


def test_no_events_give_zero_rates() -> None:
    found = fit_static(empty_events(), width=4, height=4, end_us=1_000_000)
    assert found == StaticFit(0.0, 0.0, None, None, None, None, 0.0)


def test_events_of_another_sensor_are_refused() -> None:
    events = recording_of(SensorConfig(), lux=0.1, duration_s=1.0).events
    with pytest.raises(EventError, match="0 to 3"):
        fit_static(events, width=4, height=4, end_us=1_000_000)


@pytest.mark.parametrize(
    ("known", "words"),
    [
        ({"end_us": 499}, r"end_us is 499\. Allowed is a finite number from 500"),
        ({"end_us": float("inf")}, "end_us is inf"),
        ({"end_us": float("nan")}, "end_us is nan"),
        ({"leak_drift_per_s": 0.0}, r"leak_drift_per_s is 0\.0\. Allowed is a positive"),
        ({"leak_drift_per_s": -0.018}, "leak_drift_per_s is -0.018"),
        ({"width": 0}, r"width is 0\. Allowed is a whole number from 1"),
    ],
)
def test_bad_arguments_are_refused(known: Any, words: str) -> None:
    events = np.array([(500, 1, 1, True)], EVENT_DTYPE)
    with pytest.raises(FitError, match=words):
        fit_static(events, **{"width": 4, "height": 4, "end_us": 1000, **known})
