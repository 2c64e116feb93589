"""Leak and thresholds relative to each other, estimated from static recordings."""

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


def recording_of(config: SensorConfig, *, lux: float, duration_s: float) -> Recording:
    sensor = bench_sensor(config, width=SIDE_PX, height=SIDE_PX)
    luminance = uniform_frame(sensor, chip_luminance(sensor, lux))
    return record(sensor, static_samples(luminance, duration_s=duration_s), seed=7)


def fit(recording: Recording, leak_hz: float = 0.0) -> StaticFit:
    size = {"width": SIDE_PX, "height": SIDE_PX}
    return fit_static(recording.events, **size, end_us=recording.duration_us, leak_hz=leak_hz)


@pytest.mark.parametrize("leak_hz", [0.05, 0.2])
def test_bright_light_shows_the_leak_and_its_spread(leak_hz: float) -> None:
    config = SensorConfig(leak_hz=leak_hz, leak_hz_per_lux=0.0, leak_spread=0.4)
    found = fit(recording_of(config, lux=300.0, duration_s=20.0 / leak_hz))
    assert found.leak_hz == pytest.approx(leak_hz, rel=0.1)
    assert found.leak_spread == pytest.approx(0.45, abs=0.1)  # a tenth is in the tail
    assert (found.theta_ratio, found.relative_mismatch) == (None, None)


@pytest.mark.parametrize(("theta_on", "theta_off"), [(0.28, 0.35), (0.3, 0.24)])
def test_dim_light_shows_the_ratio_of_the_thresholds(theta_on: float, theta_off: float) -> None:
    config = SensorConfig(
        theta_on=theta_on, theta_off=theta_off, noise_sigma=0.12, leak_hz=0.0, leak_hz_per_lux=0.0
    )
    found = fit(recording_of(config, lux=0.1, duration_s=60.0))
    assert found.theta_ratio == pytest.approx(theta_off / theta_on, rel=0.05)
    relative = 0.024 * np.hypot(1.0 / theta_on, 1.0 / theta_off) / np.sqrt(2.0)
    assert found.relative_mismatch == pytest.approx(relative, rel=0.25)
    assert found.leak_hz is None


def test_a_known_leak_is_subtracted() -> None:
    config = SensorConfig(
        noise_sigma=0.12, leak_hz=0.2, leak_spread=0.0, leak_tail_fraction=0.0, leak_hz_per_lux=0.0
    )
    recording = recording_of(config, lux=0.1, duration_s=30.0)
    assert fit(recording, 0.2).theta_ratio == pytest.approx(0.35 / 0.28, rel=0.05)
    assert fit(recording).theta_ratio > 1.03 * 0.35 / 0.28


def test_hot_pixels_are_left_out() -> None:
    config = SensorConfig(hot_fraction=0.01, leak_tail_fraction=0.0)
    found = fit(recording_of(config, lux=100.0, duration_s=200.0))
    assert 0.004 < found.hot_share < 0.02
    assert found.leak_hz == pytest.approx(0.0526, rel=0.15)


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
        ({"leak_hz": -0.018}, "leak_hz is -0.018. Allowed is a finite number from 0 Hz"),
        ({"leak_hz": float("nan")}, "leak_hz is nan"),
        ({"width": 0}, r"width is 0\. Allowed is a whole number from 1"),
    ],
)
def test_bad_arguments_are_refused(known: Any, words: str) -> None:
    events = np.array([(500, 1, 1, True)], EVENT_DTYPE)
    with pytest.raises(FitError, match=words):
        fit_static(events, **{"width": 4, "height": 4, "end_us": 1000, **known})
