"""Both thresholds from a known modulation."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from emulator import FitError, SensorConfig
from emulator.characterisation.bench import chip_luminance, record, resized, uniform
from emulator.characterisation.ramp_fit import Thresholds, fit_ramps
from flybench.events import EVENT_DTYPE, empty_events

SIDE_PX = 24


@pytest.mark.parametrize(("theta_on", "theta_off"), [(0.18, 0.22), (0.3, 0.15)])
def test_thresholds_and_mismatch_are_recovered_through_all_noise(
    theta_on: float, theta_off: float
) -> None:
    config = replace(SensorConfig(), theta_on=theta_on, theta_off=theta_off, theta_mismatch=0.02)
    sensor = resized(config, width=SIDE_PX, height=SIDE_PX)
    t_us = np.arange(9) * 1_000_000
    log_lux = np.where(np.arange(9) % 2, 7.0, 3.0)
    light = [uniform(sensor, chip_luminance(sensor, np.exp(u))) for u in log_lux]
    recording = record(sensor, zip(t_us.tolist(), light, strict=True), seed=1)
    found = fit_ramps(
        recording.events,
        width=SIDE_PX,
        height=SIDE_PX,
        t_us=t_us,
        log_light=log_lux,
        leak_drift_per_s=config.leak_hz * theta_on,
    )
    assert found.theta_on == pytest.approx(theta_on, rel=0.02)
    assert found.theta_off == pytest.approx(theta_off, rel=0.02)
    assert found.mismatch_on == pytest.approx(0.02, rel=0.1)
    assert found.mismatch_off == pytest.approx(0.02, rel=0.1)


def test_silence_tells_nothing() -> None:
    found = fit_ramps(empty_events(), width=4, height=4, t_us=[0, 1000], log_light=[1.0, 2.0])
    assert found == Thresholds(None, None, None, None)


def test_constant_light_tells_nothing() -> None:
    events = np.array([(100 * k, 1, 1, k % 4 < 2) for k in range(1, 9)], EVENT_DTYPE)
    found = fit_ramps(events, width=4, height=4, t_us=[0, 1000], log_light=[2.0, 2.0])
    assert found == Thresholds(None, None, None, None)


@pytest.mark.parametrize(
    ("known", "words"),
    [
        ({"t_us": [0, 2000, 1000], "log_light": [1.0, 2.0, 1.0]}, "corner 2 is at 1000 µs after"),
        ({"t_us": [0, 1000, 2000]}, r"t_us has shape \(3,\) and log_light \(2,\)"),
        ({"log_light": [1.0, np.nan]}, "holds NaN or infinity"),
        ({"log_light": ["dark", "bright"]}, "no number"),
        ({"leak_drift_per_s": -0.01}, "leak_drift_per_s is -0.01"),
        ({"leak_drift_per_s": np.inf}, "leak_drift_per_s is inf"),
        ({"height": 0}, "height is 0; allowed is a whole number of pixels from 1"),
    ],
)
def test_a_modulation_that_is_none_is_refused(known: Any, words: str) -> None:
    given = {"width": 4, "height": 4, "t_us": [0, 1000], "log_light": [1.0, 2.0], **known}
    with pytest.raises(FitError, match=words):
        fit_ramps(empty_events(), **given)
