"""Modules with users' detector classes, good and bad."""

from pathlib import Path

import pytest

SOME_DETECTORS = """
from detector.estimate import Direction, MotionEstimate

class Good:
    def __init__(self, *, width, height):
        self.size = width, height
    def push(self, events):
        return []
    def advance(self, t_us):
        return [MotionEstimate(t_us, 0.0, 0.0, Direction.NONE, 0.0, (0.0, 0.0), (0.0, 0.0), None)]

class NoAdvance:
    def push(self, events): ...

class NeedsGain(Good):
    def __init__(self, gain, *, width, height): ...

class Breaking(Good):
    def __init__(self, *, width, height):
        raise ZeroDivisionError("no room")

class Large(Good):
    def __init__(self, *, width, height):
        from flybench.memory import check_memory
        check_memory("A large detector", 9 * 10**12)

class InPlace(Good):
    def push(self, events):
        events["t"] -= 5
        return []

class InPlaceByForce(Good):
    def push(self, events):
        events.setflags(write=True)
        return []

class InPlaceFrame(Good):
    def push_frame(self, t_us, image):
        image[:] = 0
        return []

class InPlaceThroughOpenCv(Good):
    def push_frame(self, t_us, image):
        import cv2
        cv2.rectangle(image, (0, 0), (1, 1), 255)
        return []

class NoList(Good):
    def advance(self, t_us):
        return None

class ListOfStrings(Good):
    def push(self, events):
        return ["right"]

class Scripted(Good):
    answers = []
    def advance(self, t_us):
        return [self.estimate(*answer) for answer in self.answers]
    def estimate(self, t_us, hs=0.0, response=(0.0, 0.0), direction=Direction.NONE, box=None):
        return MotionEstimate(t_us, hs, 0.0, direction, 0.0, response, (0.0, 0.0), box)

class RepeatedTime(Scripted):
    answers = [(20,), (20,)]

class Backwards(Scripted):
    answers = [(20,), (10,)]

class NotANumber(Scripted):
    answers = [(20, float("nan"))]

class Infinite(Scripted):
    answers = [(20, 0.0, (float("inf"), 0.0))]

class NoResponse(Scripted):
    answers = [(20, 0.0, None)]

class DirectionAsString(Scripted):
    answers = [(20, 0.0, (0.0, 0.0), "right")]

class HalfBox(Scripted):
    answers = [(20, 0.0, (0.0, 0.0), Direction.NONE, (3, 4))]

class LargeHs(Scripted):
    answers = [(20, 5.0)]

class ScalarResponse(Scripted):
    answers = [(20, 0.0, 0.5)]

class InvertedBox(Scripted):
    answers = [(20, 0.0, (0.0, 0.0), Direction.NONE, (9, 9, 1, 1))]

class LargeStrength(Scripted):
    def estimate(self, t_us):
        return MotionEstimate(t_us, 0.5, 0.0, Direction.RIGHT, 7.0, (1.0, 0.0), (0.0, 0.0), None)
    answers = [(20,)]

class AnyEstimate(Good):
    def advance(self, t_us):
        good = {
            "t_us": t_us, "hs": 0.0, "vs": 0.0, "direction": Direction.NONE, "strength": 0.0,
            "response": (0.0, 0.0), "view_centre_px": (0.0, 0.0), "roi_px": None,
        }
        return [MotionEstimate(**(good | self.changes))]

class Raising(Good):
    def advance(self, t_us):
        if t_us > 100:
            raise ZeroDivisionError("no wind")
        return super().advance(t_us)

class Numpy(Good):
    def push(self, events):
        import numpy
        numpy.reshape(numpy.zeros(3), (2, 2))

class Quitting(Good):
    def push(self, events):
        raise SystemExit(0)

class FrameLogger(Good):
    def __init__(self, *, width, height):
        self.received = []
    def push(self, events):
        self.received += events["t"].tolist()
        return []
    def push_frame(self, t_us, frame):
        self.received.append((t_us, int(frame[0, 0])))
        return []

def function(*, width, height): ...
"""


@pytest.fixture
def user_modules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the modules `some_detectors`, `broken`, `quitting` and `misspelt` importable."""
    (tmp_path / "some_detectors.py").write_text(SOME_DETECTORS)
    (tmp_path / "broken.py").write_text("import some_library_that_is_not_there\n")
    (tmp_path / "quitting.py").write_text("raise SystemExit(0)\n")
    (tmp_path / "misspelt.py").write_text("def f(:\n")
    monkeypatch.syspath_prepend(tmp_path)
