"""The change of the light at an event, against calculations by hand and the emulator."""

import numpy as np
import pytest

from emulator import SensorConfig
from scenarios.calibrate.fits.event_steps import event_steps, noise_by_pixel
from scenarios.calibrate.recording import PixelEvents, events_by_pixel
from tests.scenarios.event_statistics.made_events import events_of

SILENT = SensorConfig(noise_sigma=0.0, refractory_us=100)


def one_pixel(times_us: list[int], on: list[bool]) -> PixelEvents:
    events = events_of(*[(t, 0, 0, p) for t, p in zip(times_us, on, strict=True)])
    return events_by_pixel(events, (1, 1))


def test_a_steady_slope_loses_its_share_of_the_refractory_period() -> None:
    """Each 500 µs has 100 µs of reset, so that an event stands for 500/400 thresholds."""
    events = one_pixel([1000, 1500, 2000, 2500], [True] * 4)
    steps = event_steps(events, np.array([100.0]), SILENT, 0.3, 0.3)
    np.testing.assert_allclose(steps.gain[1:3], 1.25)
    np.testing.assert_array_equal(steps.shift, 0.0)


def test_alternating_events_stand_for_one_threshold() -> None:
    events = one_pixel([1000, 1500, 2000], [True, False, True])
    steps = event_steps(events, np.array([100.0]), SILENT, 0.3, 0.3)
    np.testing.assert_array_equal(steps.gain, 1.0)


def test_noise_makes_an_event_stand_for_less() -> None:
    noisy = SensorConfig(noise_sigma=0.08, follower_hz=0.0, refractory_us=300)
    events = one_pixel([1000, 6000, 11_000], [True, True, False])
    steps = event_steps(events, np.array([10.0]), noisy, 0.3, 0.3)
    sigma, _ = noise_by_pixel(np.array([10.0]), noisy)
    assert -7.0 * sigma[0] < steps.shift[1] < 0.0
    assert steps.shift[2] > 0.0


def test_noise_far_from_the_threshold_changes_nothing() -> None:
    calm = SensorConfig(noise_sigma=0.01)
    steps = event_steps(one_pixel([1000], [True]), np.array([1.0]), calm, 0.3, 0.3)
    assert steps.shift[0] == pytest.approx(0.0)
