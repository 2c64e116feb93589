"""Both thresholds, estimated from a known modulation."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from emulator import FitError, SensorConfig
from emulator.characterisation.bench import bench_sensor, chip_luminance, record, uniform_frame
from emulator.characterisation.ramp_fit import Thresholds, fit_ramps
from flybench.events import EVENT_DTYPE, empty_events

SIDE_PX = 24


@pytest.mark.parametrize(("theta_on", "theta_off"), [(0.18, 0.22), (0.3, 0.15)])
def test_thresholds_and_mismatch_are_recovered_in_noise(theta_on: float, theta_off: float) -> None:
    config = replace(SensorConfig(), theta_on=theta_on, theta_off=theta_off, theta_mismatch=0.02)
    sensor = bench_sensor(config, width=SIDE_PX, height=SIDE_PX)
    t_us = np.arange(9) * 1_000_000
    log_lux = np.where(np.arange(9) % 2, 7.0, 3.0)
    frames = [uniform_frame(sensor, chip_luminance(sensor, np.exp(u))) for u in log_lux]
    recording = record(sensor, zip(t_us.tolist(), frames, strict=True), seed=1)
    found = fit_ramps(
        recording.events,
        width=SIDE_PX,
        height=SIDE_PX,
        t_us=t_us,
        log_luminance=log_lux,
        leak_drift_per_s=config.leak_hz * theta_on,
        refractory_us=config.refractory_us,
    )
    assert found.theta_on == pytest.approx(theta_on, rel=0.05)  # noise helps to cross
    assert found.theta_off == pytest.approx(theta_off, rel=0.05)
    assert found.mismatch_on == pytest.approx(0.02, rel=0.1)
    assert found.mismatch_off == pytest.approx(0.02, rel=0.1)


def test_no_events_give_no_thresholds() -> None:
    found = fit_ramps(empty_events(), width=4, height=4, t_us=[0, 1000], log_luminance=[1.0, 2.0])
    assert found == Thresholds(None, None, None, None)


def test_constant_luminance_gives_no_thresholds() -> None:
    events = np.array([(100 * k, 1, 1, k % 4 < 2) for k in range(1, 9)], EVENT_DTYPE)
    found = fit_ramps(events, width=4, height=4, t_us=[0, 1000], log_luminance=[2.0, 2.0])
    assert found == Thresholds(None, None, None, None)


@pytest.mark.parametrize(
    ("known", "words"),
    [
        (
            {"t_us": [0, 2000, 1000], "log_luminance": [1.0, 2.0, 1.0]},
            "corner 2 is at 1000 µs, after",
        ),
        ({"t_us": [0, 1000, 2000]}, r"t_us has shape \(3,\) and log_luminance has shape \(2,\)"),
        ({"log_luminance": [1.0, np.nan]}, "holds NaN or infinity"),
        ({"log_luminance": ["dark", "bright"]}, "other than numbers"),
        ({"leak_drift_per_s": -0.01}, "leak_drift_per_s is -0.01"),
        ({"refractory_us": -1}, "refractory_us is -1"),
        ({"leak_drift_per_s": np.inf}, "leak_drift_per_s is inf"),
        ({"height": 0}, r"height is 0\. Allowed is a whole number from 1"),
    ],
)
def test_a_bad_modulation_is_refused(known: Any, words: str) -> None:
    given = {"width": 4, "height": 4, "t_us": [0, 1000], "log_luminance": [1.0, 2.0], **known}
    with pytest.raises(FitError, match=words):
        fit_ramps(empty_events(), **given)
