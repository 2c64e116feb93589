import numpy as np
import numpy.typing as npt
import pytest

from detector.estimate import Detector, FrameDetector, MotionEstimate
from detector.fly.detector import FlyDetector
from flybench.direction import Direction
from flybench.events import Events


@pytest.mark.parametrize(
    ("name", "angle_deg"), [("right", 0.0), ("down", 90.0), ("left", 180.0), ("up", -90.0)]
)
def test_angles_follow_the_convention(name: str, angle_deg: float) -> None:
    assert Direction(name).angle_deg == angle_deg


def test_none_has_no_angle() -> None:
    assert Direction.NONE.angle_deg is None


def test_the_fly_is_a_detector() -> None:
    detector: Detector = FlyDetector()
    assert detector.advance(20_000)[0].direction is Direction.NONE
    assert not isinstance(detector, FrameDetector)


class FramesOnly:
    """Reports rightward motion at every frame and ignores events."""

    def push(self, _: Events) -> list[MotionEstimate]:
        return []

    def advance(self, _: int) -> list[MotionEstimate]:
        return []

    def push_frame(self, t_us: int, _: npt.NDArray[np.uint16]) -> list[MotionEstimate]:
        return [MotionEstimate(t_us, 0.5, 0.0, Direction.RIGHT, 0.5, (1.0, 0.0), (0.0, 0.0), None)]


def test_a_class_with_push_frame_is_a_frame_detector() -> None:
    detector = FramesOnly()
    assert isinstance(detector, FrameDetector)
    assert detector.push_frame(5, np.zeros((260, 346), np.uint16))[0].t_us == 5
