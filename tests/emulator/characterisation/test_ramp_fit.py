"""Both thresholds from a known modulation."""

from dataclasses import replace

import numpy as np
import pytest

from emulator import SensorConfig, empty_events
from emulator.characterisation.bench import chip_luminance, record, resized, uniform
from emulator.characterisation.ramp_fit import Thresholds, fit_ramps

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
