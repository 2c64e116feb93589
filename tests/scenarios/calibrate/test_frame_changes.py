"""Frames predicted from events, against calculations by hand."""

import math

import numpy as np
import pytest

from emulator import ApsFrame, SensorConfig
from scenarios.calibrate.fits.event_steps import EventSteps
from scenarios.calibrate.fits.frame_changes import Predicted, predict_frames
from scenarios.calibrate.recording import CalibrationRecording, events_by_pixel
from tests.scenarios.event_statistics.made_events import events_of

ON, OFF = 0.3, 0.4


def predict(
    exposures_us: list[tuple[int, int]], share: float = 0.0, lag_us: float = 0.0
) -> Predicted:
    """ON events at 10, 20 and 30 ms and an OFF event at 50 ms, at one pixel."""
    times = [(10_000, True), (20_000, True), (30_000, True), (50_000, False)]
    events = events_of(*[(t, 0, 0, on) for t, on in times])
    image = np.full((1, 1), 100, np.uint16)
    frames = tuple(ApsFrame(a, b, image) for a, b in exposures_us)
    recording = CalibrationRecording(events, frames, np.ones(len(frames)))
    count = events.size
    steps = EventSteps(np.ones(count, np.float32), np.zeros(count, np.float32), np.array([lag_us]))
    by_pixel = events_by_pixel(events, (1, 1))
    return predict_frames(recording, by_pixel, np.array([0]), steps, (ON, OFF, share))


def test_a_frame_of_one_moment_counts_the_events_before_it() -> None:
    found = predict([(5_000, 5_000), (35_000, 35_000), (60_000, 60_000)])
    np.testing.assert_allclose(found.log[:, 0], [0.0, 3 * ON, 3 * ON - OFF], rtol=1e-6)
    np.testing.assert_allclose(found.per_on[:, 0], [0, 3, 3])
    np.testing.assert_allclose(found.per_off[:, 0], [0, 0, -1])


def test_a_blurred_frame_is_the_mean_of_the_light() -> None:
    found = predict([(5_000, 5_000), (15_000, 25_000)])
    expected = math.log((math.exp(ON) + math.exp(2 * ON)) / 2)
    assert found.log[1, 0] == pytest.approx(expected, rel=1e-6)
    weights = math.exp(ON), math.exp(2 * ON)
    assert found.per_on[1, 0] == pytest.approx((weights[0] + 2 * weights[1]) / sum(weights))


def test_the_light_lies_beyond_the_last_threshold_by_a_share_of_it() -> None:
    found = predict([(35_000, 35_000), (60_000, 60_000)], share=0.5)
    np.testing.assert_allclose(found.log[:, 0], [3.5 * ON, 3 * ON - 1.5 * OFF], rtol=1e-6)


def test_the_output_lags_behind_the_light() -> None:
    assert predict([(9_500, 9_500)], lag_us=1_000.0).per_on[0, 0] == 1.0


def test_the_derivatives_are_those_of_the_prediction() -> None:
    assert SensorConfig().theta_on != ON
    exposures = [(5_000, 12_000), (15_000, 55_000)]
    found, step = predict(exposures, share=0.3), 1e-3
    more = predict(exposures, share=0.3 + step)
    np.testing.assert_allclose((more.log - found.log) / step, found.per_share, rtol=2e-2, atol=1e-3)
