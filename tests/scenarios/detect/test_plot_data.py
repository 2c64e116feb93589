"""Data of the figure: snapshot and event rate."""

import numpy as np

from detector.estimate import MotionEstimate
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import EVENT_DTYPE
from scenarios.detect.plot_data import PlotData
from scenarios.detect.run_detector import RecordingSlice


def estimate_at(t_us: int, direction: Direction, strength: float) -> MotionEstimate:
    return MotionEstimate(t_us, 0.1, 0.1, direction, strength, (0.0, 0.0), (0.0, 0.0), None)


def test_the_snapshot_is_that_of_the_strongest_estimate() -> None:
    data = PlotData()
    for k in range(20):
        events = np.zeros(10, EVENT_DTYPE)
        events["t"] = k * 10_000 + np.arange(10) * 1000
        direction = Direction.UP if k > 3 else Direction.NONE
        estimate = estimate_at(k * 10_000, direction, 0.9 if k == 12 else 0.3)
        data.add(RecordingSlice(events, (), (estimate,), None, 0))
    assert data.snapshot.estimate is not None
    assert data.snapshot.estimate.t_us == 120_000
    times_us = data.snapshot.events["t"]
    assert times_us.min() == 100_000
    assert times_us.max() == 119_000
    times_s, (on, off) = data.rates()
    assert on.sum() == 0.0
    assert np.all(off[:-1] == 1000.0)
    assert times_s[0] == 0.005


def test_the_frame_is_the_last_that_ended_before_the_estimate() -> None:
    """The estimate for 120 ms arrives together with later events and a later frame."""
    data, image = PlotData(), np.zeros((2, 2), np.uint16)
    for k in range(20):
        end_us = 10_000 * k + 5000
        frame = ApsFrame(end_us - 5000, end_us, image)
        events = np.zeros(1, EVENT_DTYPE)
        events["t"] = end_us
        estimate = estimate_at(10_000 * (k - 1), Direction.UP, 0.9 if k == 13 else 0.3)
        data.add(RecordingSlice(events, (frame,), (estimate,), None, 0))
    assert data.snapshot.estimate is not None
    assert data.snapshot.estimate.t_us == 120_000
    assert data.snapshot.frame is not None
    assert data.snapshot.frame.end_us == 115_000


def test_the_event_rate_of_a_long_pause_has_few_bins() -> None:
    data = PlotData()
    for t_us in (0, 86_400_000_000):
        events = np.zeros(1, EVENT_DTYPE)
        events["t"] = t_us
        data.add(RecordingSlice(events, (), (), None, 0))
    times_s, rates = data.rates()
    assert times_s.size == rates.shape[1] <= 2001
