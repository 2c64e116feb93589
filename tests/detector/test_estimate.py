import pytest

from detector.estimate import Detector, Direction
from detector.fly import FlyDetector


@pytest.mark.parametrize(
    ("name", "angle_deg"), [("right", 0.0), ("down", 90.0), ("left", 180.0), ("up", -90.0)]
)
def test_zero_is_right_and_ninety_is_down(name: str, angle_deg: float) -> None:
    assert Direction(name).angle_deg == angle_deg


def test_none_has_no_angle() -> None:
    assert Direction.NONE.angle_deg is None


def test_the_fly_is_a_detector() -> None:
    detector: Detector = FlyDetector()
    assert detector.advance(20_000)[0].direction is Direction.NONE
