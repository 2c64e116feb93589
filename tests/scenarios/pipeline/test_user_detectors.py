from pathlib import Path

import numpy as np
import pytest

from detector.contrast_maximisation.detector import ContrastMaximisation
from detector.estimate import FrameDetector
from detector.fly.config import FlyConfig
from detector.fly.detector import FlyDetector
from detector.frame_fly.detector import FrameFly
from detector.plane_fit.detector import PlaneFit
from emulator import ApsFrame
from flybench.events import empty_events
from scenarios.errors import MethodError, ScenarioError
from scenarios.pipeline.feeding import feed
from scenarios.pipeline.registry import DETECTORS
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.user_detectors import find_method
from tests.scenarios.drawn_events import events_at

USERS_MODULE = """
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

class Greedy(Good):
    def __init__(self, gain, *, width, height): ...

class Breaking(Good):
    def __init__(self, *, width, height):
        raise ZeroDivisionError("no room")

class Silent(Good):
    def advance(self, t_us):
        return None

class Wordy(Good):
    def push(self, events):
        return ["right"]

class Saying(Good):
    answers = []
    def advance(self, t_us):
        return [self.estimate(*answer) for answer in self.answers]
    def estimate(self, t_us, hs=0.0, response=(0.0, 0.0), direction=Direction.NONE, box=None):
        return MotionEstimate(t_us, hs, 0.0, direction, 0.0, response, (0.0, 0.0), box)

class Stuck(Saying):
    answers = [(20,), (20,)]

class Backwards(Saying):
    answers = [(20,), (10,)]

class NotANumber(Saying):
    answers = [(20, float("nan"))]

class Endless(Saying):
    answers = [(20, 0.0, (float("inf"), 0.0))]

class NoResponse(Saying):
    answers = [(20, 0.0, None)]

class JustAWord(Saying):
    answers = [(20, 0.0, (0.0, 0.0), "right")]

class Half(Saying):
    answers = [(20, 0.0, (0.0, 0.0), Direction.NONE, (3, 4))]

class Strong(Saying):
    answers = [(20, 5.0)]

class Single(Saying):
    answers = [(20, 0.0, 0.5)]

class InsideOut(Saying):
    answers = [(20, 0.0, (0.0, 0.0), Direction.NONE, (9, 9, 1, 1))]

class TooStrong(Saying):
    def estimate(self, t_us):
        return MotionEstimate(t_us, 0.5, 0.0, Direction.RIGHT, 7.0, (1.0, 0.0), (0.0, 0.0), None)
    answers = [(20,)]

class Watcher(Good):
    def __init__(self, *, width, height):
        self.seen = []
    def push(self, events):
        self.seen += events["t"].tolist()
        return []
    def push_frame(self, t_us, frame):
        self.seen.append((t_us, int(frame[0, 0])))
        return []

def function(*, width, height): ...
"""


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "some_detectors.py").write_text(USERS_MODULE)
    (tmp_path / "broken.py").write_text("import some_library_that_is_not_there\n")
    (tmp_path / "misspelt.py").write_text("def f(:\n")
    monkeypatch.syspath_prepend(tmp_path)


@pytest.mark.parametrize(("name", "preset"), [("fly", "paper"), ("wide", "wide")])
def test_the_fly_has_a_name_for_each_preset(name: str, preset: str) -> None:
    fly = find_method(name).make(width=346, height=260)
    assert isinstance(fly, FlyDetector)
    assert fly.config == FlyConfig.preset(preset)
    assert RunConfig(method=name).fly == FlyConfig.preset(preset)


def test_every_entry_says_what_its_detector_is() -> None:
    for entry in DETECTORS.values():
        detector = entry.make(width=346, height=260)
        assert detector.config == entry.config  # type: ignore[attr-defined]
        assert isinstance(detector, FrameDetector) == entry.looks_at_frames


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("frame-fly", FrameFly),
        ("frame-fly-coarse", FrameFly),
        ("contrast-maximisation", ContrastMaximisation),
        ("plane-fit", PlaneFit),
    ],
)
def test_the_baselines_go_by_name(name: str, kind: type) -> None:
    detector = find_method(name).make(width=64, height=48)
    assert isinstance(detector, kind)
    assert isinstance(detector, FrameDetector) == (kind is FrameFly)
    assert RunConfig(method=name).fly is None


def test_a_users_class_is_made_for_the_sensors_size() -> None:
    method = find_method("some_detectors:Good")
    assert method.name == "some_detectors:Good"
    assert method.make(width=64, height=48).size == (64, 48)  # type: ignore[attr-defined]
    assert RunConfig(method="some_detectors:Good").fly is None


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("bee", ("'bee'", "fly, wide", "package.module:Class")),
        ("some_detectors", ("'some_detectors'", "package.module:Class")),
        ("some_detectors:", ("package.module:Class",)),
        ("nowhere:Good", ("there is no nowhere", "PYTHONPATH")),
        ("nowhere.deeper:Good", ("there is no nowhere",)),
        ("some_detectors.deeper:Good", ("there is no some_detectors.deeper",)),
        ("broken:Good", ("broken", "cannot be imported", "some_library_that_is_not_there", "line")),
        ("misspelt:Good", ("misspelt", "cannot be imported", "SyntaxError")),
        ("some_detectors:Bad", ("no class Bad", "it offers Good")),
        ("some_detectors:NoAdvance", ("has no method advance", "it offers Good")),
        ("some_detectors:function", ("has no method push or advance",)),
        ("some_detectors:Direction", ("has no method",)),
        ("some_detectors:Greedy", ("Greedy(width=346, height=260)", "'gain'")),
    ],
)
def test_a_method_that_is_not_there_is_refused_in_a_sentence(
    name: str, words: tuple[str, ...]
) -> None:
    with pytest.raises(MethodError) as refused:
        find_method(name)
    for word in words:
        assert word in str(refused.value)


def test_a_detector_that_cannot_be_made_says_why_and_where() -> None:
    make = find_method("some_detectors:Breaking").make
    with pytest.raises(MethodError, match=r"ZeroDivisionError: no room \(some_detectors.py, line"):
        make(width=346, height=260)


def test_reading_is_pushing_and_advancing() -> None:
    detector = find_method("some_detectors:Good").make(width=346, height=260)
    (estimate,) = feed(detector, empty_events(), until_us=70)
    assert estimate.t_us == 70


def test_frames_come_between_the_events_before_and_after_them() -> None:
    watcher = find_method("some_detectors:Watcher").make(width=346, height=260)
    frames = [ApsFrame(0, end, np.full((2, 2), end, np.uint16)) for end in (20, 30)]
    feed(watcher, events_at(10, 19, 20, 40), until_us=50, frames=frames)
    assert watcher.seen == [10, 19, (20, 20), 20, (30, 30), 40]  # type: ignore[attr-defined]
    without = find_method("some_detectors:Good").make(width=346, height=260)
    assert len(feed(without, events_at(10), until_us=50, frames=frames)) == 1


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Silent", "Silent.advance returned NoneType"),
        ("Wordy", "a list of str"),
        ("Stuck", "Stuck returned an estimate at 20 µs after one at 20 µs; allowed"),
        ("Backwards", "an estimate at 10 µs after one at 20 µs"),
        ("NotANumber", "NotANumber.advance returned an estimate at 20 µs whose hs is nan; allowed"),
        ("Endless", r"whose response is \(inf, 0.0\)"),
        ("NoResponse", "whose response is None"),
        ("JustAWord", "whose direction is 'right'; allowed is a detector.estimate.Direction"),
        ("Half", r"whose roi_px is \(3, 4\); allowed is"),
        ("Strong", "whose hs is 5.0; allowed is -1 to 1"),
        ("TooStrong", "whose strength is 7.0; allowed is 0 to 1"),
        ("Single", "whose response is 0.5; allowed are two numbers"),
        ("InsideOut", r"whose roi_px is \(9, 9, 1, 1\); allowed is .*x0 < x1"),
    ],
)
def test_an_answer_that_is_no_estimate_is_refused(name: str, words: str) -> None:
    detector = find_method(f"some_detectors:{name}").make(width=346, height=260)
    with pytest.raises(MethodError, match=words):
        feed(detector, empty_events(), until_us=70)


def test_estimates_rise_from_one_reading_to_the_next() -> None:
    detector = find_method("some_detectors:Good").make(width=346, height=260)
    said = feed(detector, empty_events(), until_us=70)
    said += feed(detector, empty_events(), until_us=80, said=said)
    assert [e.t_us for e in said] == [70, 80]
    with pytest.raises(MethodError, match="at 80 µs after one at 80 µs"):
        feed(detector, empty_events(), until_us=80, said=said)


def test_the_flys_parameters_are_for_the_fly_alone() -> None:
    with pytest.raises(ScenarioError, match="has parameters of the fly"):
        RunConfig(method="some_detectors:Good", fly=FlyConfig())
    assert "fly.tau_us" in RunConfig().parameters()
    assert RunConfig(method="some_detectors:Good").parameters()["fly"] is None


def test_a_runs_name_tells_the_method() -> None:
    assert RunConfig().name.endswith("seed0")
    assert RunConfig(method="wide").name.endswith("seed0_wide")
    assert ":" not in RunConfig(method="some_detectors:Good").name
