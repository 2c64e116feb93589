"""The verdict on a recording."""

from detector.estimate import MotionEstimate
from detector.metrics import verdict
from flybench.direction import Direction
from scenarios.detect.verdict import RecordingVerdict


def estimate_at(t_us: int, direction: Direction, strength: float) -> MotionEstimate:
    return MotionEstimate(t_us, 0.1, 0.1, direction, strength, (0.0, 0.0), (0.0, 0.0), None)


def test_the_verdict_is_that_of_a_crossing_over_all_estimates() -> None:
    estimates = [
        estimate_at(1, Direction.LEFT, 0.3),
        estimate_at(2, Direction.LEFT, 0.3),
        estimate_at(3, Direction.UP, 0.9),
        estimate_at(4, Direction.NONE, 0.99),
    ]
    found = RecordingVerdict()
    for estimate in estimates:
        found.add(estimate)
    assert found.direction is verdict(estimates, crossing_us=(0, 9)) is Direction.UP
    assert found.share == 0.9 / 1.5
    assert found.counts == {Direction.LEFT: 2, Direction.UP: 1, Direction.NONE: 1}


def test_without_estimates_the_verdict_is_none() -> None:
    assert RecordingVerdict().direction is Direction.NONE
    assert RecordingVerdict().share == 0.0
