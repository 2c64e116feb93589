"""The verdict, and what a figure shows."""

import numpy as np

from detector.estimate import MotionEstimate
from detector.metrics import verdict
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import EVENT_DTYPE
from scenarios.detect.tally import Curves, Verdict
from scenarios.detect.watching import Look


def said(t_us: int, direction: Direction, strength: float) -> MotionEstimate:
    return MotionEstimate(t_us, 0.1, 0.1, direction, strength, (0.0, 0.0), (0.0, 0.0), None)


def test_strength_decides_as_it_does_for_a_crossing() -> None:
    steps = [
        said(1, Direction.LEFT, 0.3),
        said(2, Direction.LEFT, 0.3),
        said(3, Direction.UP, 0.9),
        said(4, Direction.NONE, 0.99),
    ]
    found = Verdict()
    for step in steps:
        found.add(step)
    assert found.direction is verdict(steps, crossing_us=(0, 9)) is Direction.UP
    assert found.share == 0.9 / 1.5
    assert found.counts == {Direction.LEFT: 2, Direction.UP: 1, Direction.NONE: 1}
    assert Verdict().direction is Direction.NONE
    assert Verdict().share == 0.0


def test_the_picture_is_that_of_the_strongest_step() -> None:
    curves = Curves()
    for k in range(20):
        events = np.zeros(10, EVENT_DTYPE)
        events["t"] = k * 10_000 + np.arange(10) * 1000
        way = Direction.UP if k > 3 else Direction.NONE
        steps = (said(k * 10_000, way, 0.9 if k == 12 else 0.3),)
        curves.add(Look(events, (), steps, None, 0))
    assert curves.picture.estimate is not None
    assert curves.picture.estimate.t_us == 120_000
    times_us = curves.picture.events["t"]
    assert times_us.min() == 100_000
    assert times_us.max() == 119_000
    times_s, (on, off) = curves.rates()
    assert on.sum() == 0.0
    assert np.all(off[:-1] == 1000.0)
    assert times_s[0] == 0.005


def test_the_frame_is_the_last_that_had_ended_by_then() -> None:
    """The estimate of 120 ms comes with events and a frame that are later."""
    curves, image = Curves(), np.zeros((2, 2), np.uint16)
    for k in range(20):
        end_us = 10_000 * k + 5000
        frame = ApsFrame(end_us - 5000, end_us, image)
        events = np.zeros(1, EVENT_DTYPE)
        events["t"] = end_us
        step = said(10_000 * (k - 1), Direction.UP, 0.9 if k == 13 else 0.3)
        curves.add(Look(events, (frame,), (step,), None, 0))
    assert curves.picture.estimate is not None
    assert curves.picture.estimate.t_us == 120_000
    assert curves.picture.frame is not None
    assert curves.picture.frame.end_us == 115_000


def test_a_quiet_of_days_does_not_fill_the_figure() -> None:
    curves = Curves()
    for t_us in (0, 86_400_000_000):
        events = np.zeros(1, EVENT_DTYPE)
        events["t"] = t_us
        curves.add(Look(events, (), (), None, 0))
    times_s, rates = curves.rates()
    assert times_s.size == rates.shape[1] <= 2001
