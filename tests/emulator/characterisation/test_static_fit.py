"""What a static recording tells about a sensor, within the stated limits."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

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
from tests.emulator.characterisation.plain_sensor import PLAIN

SIDE_PX = 32
NOISY = SensorConfig(theta_on=0.14, theta_off=0.186, theta_mismatch=0.012)
"""Thresholds as small as those of the published recordings: six ON events a second at 0.1 lux."""


def recording_of(config: SensorConfig, *, lux: float, duration_s: float) -> Recording:
    sensor = bench_sensor(config, width=SIDE_PX, height=SIDE_PX)
    luminance = uniform_frame(sensor, chip_luminance(sensor, lux))
    return record(sensor, static_samples(luminance, duration_s=duration_s), seed=7)


def fit(recording: Recording, leak_hz: float | None = None) -> StaticFit:
    return fit_static(
        recording.events,
        width=SIDE_PX,
        height=SIDE_PX,
        end_us=recording.duration_us,
        leak_hz=leak_hz,
    )


@pytest.mark.parametrize(
    ("theta_on", "theta_off", "mismatch"),
    [(0.14, 0.186, 0.012), (0.16, 0.16, 0.008), (0.18, 0.13, 0.018)],
)
def test_ratio_and_mismatch_of_the_thresholds_are_recovered_from_noise(
    theta_on: float, theta_off: float, mismatch: float
) -> None:
    config = SensorConfig(theta_on=theta_on, theta_off=theta_off, theta_mismatch=mismatch)
    found = fit(recording_of(config, lux=0.1, duration_s=80.0))
    assert found.off_hz > 1.0
    assert found.threshold_ratio == pytest.approx(theta_off / theta_on, rel=0.05)
    assert found.relative_mismatch == pytest.approx(mismatch / theta_on, rel=0.15)
    assert found.leak_hz is None
    assert found.leak_spread is None


def test_a_known_leak_is_subtracted() -> None:
    config = replace(NOISY, leak_hz=0.5, leak_spread=0.0, leak_tail_fraction=0.0)
    recording = recording_of(config, lux=0.1, duration_s=80.0)
    unknown, known = fit(recording).threshold_ratio, fit(recording, 0.5).threshold_ratio
    assert unknown is not None
    assert unknown > 1.08 * 0.186 / 0.14
    assert known == pytest.approx(0.186 / 0.14, rel=0.03)


@pytest.mark.parametrize(
    ("leak_hz", "spread", "tail"), [(0.05, 0.4, 0.1), (0.2, 0.2, 0.0), (0.1, 0.6, 0.1)]
)
@pytest.mark.parametrize("lux", [300.0, 3000.0])
def test_the_leak_and_its_spread_are_recovered_in_bright_light(
    leak_hz: float, spread: float, tail: float, lux: float
) -> None:
    config = SensorConfig(
        leak_hz=leak_hz, leak_hz_per_lux=0.0, leak_spread=spread, leak_tail_fraction=tail
    )
    found = fit(recording_of(config, lux=lux, duration_s=20.0 / leak_hz))
    relative = config.theta_mismatch / config.theta_on
    assert found.leak_hz == pytest.approx(leak_hz, rel=0.08)
    assert found.leak_spread == pytest.approx(np.hypot(spread, relative), rel=0.12)
    assert found.threshold_ratio is None
    assert found.relative_mismatch is None


def test_equal_leaks_spread_as_the_thresholds_do() -> None:
    found = fit(recording_of(PLAIN, lux=30.0, duration_s=200.0))
    assert found.leak_hz == pytest.approx(0.1, rel=0.03)
    assert found.leak_spread == pytest.approx(0.035 / 0.18, rel=0.15)


def test_noise_that_decays_in_the_reset_adds_to_the_leak() -> None:
    found = fit(recording_of(SensorConfig(), lux=30.0, duration_s=400.0))
    assert found.leak_hz is not None
    assert 1.03 < found.leak_hz / 0.05 < 1.2


def test_weak_noise_beside_leak_tells_neither() -> None:
    """The default sensor at 0.1 lux: half of its ON events are leak."""
    found = fit(recording_of(SensorConfig(), lux=0.1, duration_s=100.0))
    assert 0.3 < found.off_hz / found.on_hz < 0.8
    assert found.threshold_ratio is None
    assert found.leak_hz is None


def test_a_short_recording_tells_only_rates() -> None:
    found = fit(recording_of(SensorConfig(), lux=100.0, duration_s=20.0))
    assert found.on_hz == pytest.approx(0.08, rel=0.4)
    assert found.leak_hz is None


def test_rates_are_those_of_all_pixels() -> None:
    rng = np.random.default_rng(2)
    pixels, rate_hz, end_s = 10_000, 2.0, 20.0
    n = rng.poisson(pixels * rate_hz * end_s)
    events = np.zeros(n, EVENT_DTYPE)
    events["t"] = np.sort(rng.uniform(0.0, end_s * 1e6, n)).astype(int)
    events["x"], events["y"] = rng.integers(0, 100, (2, n))
    found = fit_static(events, width=100, height=100, end_us=round(end_s * 1e6))
    assert found.on_hz == 0.0
    assert found.off_hz == pytest.approx(rate_hz, rel=0.01)
    assert found.off_quantiles_hz == pytest.approx((1.5, 2.0, 2.55), abs=0.06)


def test_hot_pixels_are_counted_and_change_no_leak() -> None:
    config = replace(PLAIN, hot_fraction=0.01)
    found = fit(recording_of(config, lux=100.0, duration_s=100.0))
    assert 0.004 < found.hot_share < 0.02
    assert found.leak_hz == pytest.approx(0.1, rel=0.05)


def test_no_events_give_zero_rates() -> None:
    found = fit_static(empty_events(), width=4, height=4, end_us=1_000_000)
    none = (0.0, 0.0, 0.0)
    assert found == StaticFit(0.0, 0.0, none, none, None, None, None, None, 0.0)


def test_events_of_another_sensor_are_refused() -> None:
    events = recording_of(NOISY, lux=0.1, duration_s=1.0).events
    with pytest.raises(EventError, match="0 to 3"):
        fit_static(events, width=4, height=4, end_us=1_000_000)


@pytest.mark.parametrize(
    ("known", "words"),
    [
        ({"end_us": 499}, r"end_us is 499\. Allowed is a finite number from 500"),
        ({"end_us": float("inf")}, "end_us is inf"),
        ({"end_us": float("nan")}, "end_us is nan"),
        ({"leak_hz": -0.05}, r"leak_hz is -0\.05\. Allowed is a finite number from 0"),
        ({"leak_hz": float("nan")}, "leak_hz is nan"),
        ({"width": 0}, r"width is 0\. Allowed is a whole number from 1"),
    ],
)
def test_bad_arguments_are_refused(known: Any, words: str) -> None:
    events = np.array([(500, 1, 1, True)], EVENT_DTYPE)
    with pytest.raises(FitError, match=words):
        fit_static(events, **{"width": 4, "height": 4, "end_us": 1000, **known})
