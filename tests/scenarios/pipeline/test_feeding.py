"""Feeding a detector and checking its estimates when they come."""

from typing import Any

import numpy as np
import pytest

from detector.estimate import MotionEstimate
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import empty_events
from flybench.memory import MemoryBudgetError
from scenarios.errors import MethodError
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.pipeline.user_detectors import find_method
from tests.scenarios.timed_events import events_at

pytestmark = pytest.mark.usefixtures("user_modules")
SIZE: Any = {"width": 346, "height": 260}


def feed_of(name: str, **attributes: Any) -> DetectorFeed:
    method = f"some_detectors:{name}"
    detector = find_method(method).make(**SIZE)
    for attribute, value in attributes.items():
        setattr(detector, attribute, value)
    return DetectorFeed(method, detector, **SIZE)


def failure(feed: DetectorFeed) -> str:
    with pytest.raises(MethodError) as raised:
        feed.raise_failure()
    return str(raised.value)


def test_events_are_pushed_and_time_is_advanced() -> None:
    feed = feed_of("Good")
    (estimate,) = feed.feed(empty_events(), until_us=70)
    assert estimate.t_us == 70
    feed.raise_failure()


def test_a_frame_is_passed_between_the_events_before_and_after_it() -> None:
    logger = feed_of("FrameLogger")
    frames = [ApsFrame(0, end, np.full((2, 2), end, np.uint16)) for end in (20, 30)]
    logger.feed(events_at(10, 19, 20, 40), until_us=50, frames=frames)
    received: Any = logger.detector
    assert received.received == [10, 19, (20, 20), 20, (30, 30), 40]
    assert len(feed_of("Good").feed(events_at(10), until_us=50, frames=frames)) == 1


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("InPlace", "push"),
        ("InPlaceByForce", "push"),
        ("InPlaceFrame", "push_frame"),
        ("InPlaceThroughOpenCv", "push_frame"),
    ],
)
def test_a_detector_that_writes_in_place_is_named(name: str, call: str) -> None:
    feed = feed_of(name)
    events, image = events_at(10, 19), np.full((2, 2), 7, np.uint16)
    feed.feed(events, until_us=50, frames=[ApsFrame(0, 20, image)])
    text = failure(feed)
    assert f"{name}: {call} writes into an array that it was given" in text
    assert "Copy first" in text
    assert events["t"].tolist() == [10, 19]
    assert (image == 7).all()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("NoList", "some_detectors:NoList: advance returned NoneType. Allowed is a list"),
        ("ListOfStrings", "push returned a list with str"),
        ("RepeatedTime", "at 20 µs whose t_us is not later than the one before it, at 20 µs"),
        ("Backwards", "at 10 µs whose t_us is not later than the one before it, at 20 µs"),
        ("NotANumber", "at 20 µs whose hs is nan. Allowed is a number from -1 to 1"),
        ("Infinite", "whose response is inf. Allowed is a number"),
        ("NoResponse", "whose response is None. Allowed are two numbers"),
        ("DirectionAsString", "whose direction is 'right'. Allowed is a detector.Direction"),
        ("HalfBox", "whose roi_px is (3, 4). Allowed is"),
        ("LargeHs", "whose hs is 5.0. Allowed is a number from -1 to 1"),
        ("LargeStrength", "whose strength is 7.0. Allowed is a number from 0 to 1"),
        ("ScalarResponse", "whose response is 0.5. Allowed are two numbers"),
        ("InvertedBox", "whose roi_px is (9, 9, 1, 1). Allowed is (x0, y0, x1, y1)"),
        ("Quitting", "push raised an error after 0 µs of the stream: SystemExit: 0"),
        ("Numpy", "cannot reshape array of size 3 into shape (2,2) (some_detectors.py, line"),
    ],
)
def test_a_detector_with_an_invalid_answer_fails(name: str, words: str) -> None:
    feed = feed_of(name)
    feed.feed(empty_events(), until_us=70)
    assert failure(feed).startswith(f"some_detectors:{name}: ")
    assert words in failure(feed)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"t_us": 69.5}, "t_us is 69.5. Allowed is a whole number of µs from 0"),
        ({"t_us": np.float64(70)}, "t_us is np.float64(70.0). Allowed is a whole number"),
        ({"t_us": True}, "t_us is True"),
        ({"t_us": -1}, "t_us is -1"),
        ({"t_us": None}, "t_us is None"),
        ({"t_us": 10**15}, "later than the stream, which has reached 70 µs"),
        ({"t_us": 71}, "later than the stream, which has reached 70 µs"),
        ({"hs": "0.5"}, "hs is '0.5'"),
        ({"hs": np.array([0.5])}, "hs is array([0.5])"),
        ({"vs": np.float32(np.nan)}, "vs is np.float32(nan)"),
        ({"strength": True}, "strength is True"),
        ({"response": (0.0, 1e300)}, "response is 1e+300. Allowed is a number from -1e+12 to"),
        ({"response": "ab"}, "response is 'ab'. Allowed are two numbers"),
        ({"response": ([1], [1, 2])}, "response is [1]"),
        ({"view_centre_px": (1e300, 0.0)}, "view_centre_px x is 1e+300. ... from -346 to 692"),
        ({"view_centre_px": (0.0, 521.0)}, "view_centre_px y is 521.0. ... from -260 to 520"),
        ({"view_centre_px": (np.nan, 0.0)}, "view_centre_px x is nan"),
        ({"view_centre_px": np.zeros((2, 2))}, "view_centre_px x is array"),
        ({"roi_px": (0.5, 0, 3, 4)}, "roi_px is (0.5, 0, 3, 4). Allowed is ... whole pixels"),
        ({"roi_px": (0, 0, 347, 4)}, "x1 ≤ 346"),
        ({"roi_px": (-1, 0, 3, 4)}, "0 ≤ x0"),
        ({"roi_px": np.zeros((100, 100))}, "roi_px is array([[0., 0. ... Allowed is"),
    ],
)
def test_each_field_is_checked(changes: dict[str, Any], words: str) -> None:
    feed = feed_of("AnyEstimate", changes=changes)
    assert feed.feed(empty_events(), until_us=70) == []
    for part in words.split(" ... "):
        assert part in failure(feed)
    assert "\n" not in failure(feed)
    assert len(failure(feed)) < 400


def test_numbers_of_numpy_become_those_of_python() -> None:
    numbers = {
        "t_us": np.int64(70),
        "hs": np.float32(0.5),
        "strength": np.float16(0.5),
        "response": np.array([1.0, 2.0], np.float32),
        "view_centre_px": [np.int32(-346), np.float64(520)],
        "roi_px": np.array([0, 0, 346, 260]),
    }
    feed = feed_of("AnyEstimate", changes=numbers)
    (estimate,) = feed.feed(empty_events(), until_us=70)
    assert estimate == MotionEstimate(
        70, 0.5, 0.0, Direction.NONE, 0.5, (1.0, 2.0), (-346.0, 520.0), (0, 0, 346, 260)
    )
    assert (type(estimate.t_us), type(estimate.hs)) == (int, float)
    assert {type(value) for value in estimate.response} == {float}
    assert estimate.roi_px is not None
    assert {type(value) for value in estimate.roi_px} == {int}


def test_estimates_must_be_later_than_those_of_earlier_calls() -> None:
    feed = feed_of("Good")
    estimates = feed.feed(empty_events(), until_us=70) + feed.feed(empty_events(), until_us=80)
    assert [e.t_us for e in estimates] == [70, 80]
    assert feed.feed(empty_events(), until_us=80) == []
    assert "not later than the one before it, at 80 µs" in failure(feed)


def test_estimates_before_a_failure_are_kept_and_the_detector_gets_no_more_events() -> None:
    feed = feed_of("Backwards")
    assert [e.t_us for e in feed.feed(empty_events(), until_us=70)] == [20]
    raising = feed_of("Raising")
    found = [e.t_us for until in (70, 120, 170) for e in raising.feed(events_at(), until_us=until)]
    assert found == [70]
    assert "after 120 µs of the stream: ZeroDivisionError: no wind (some_detectors.py" in failure(
        raising
    )


class _UnprintableError(Exception):
    def __str__(self) -> str:
        raise ValueError


class _Own(BaseException):
    pass


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (_UnprintableError(), "of the stream: _UnprintableError (test_feeding.py, line"),
        (RuntimeError("y" * 9999), f"RuntimeError: {'y' * 300}... (test_feeding"),
        (RuntimeError(), "of the stream: RuntimeError (test_feeding.py, line"),
        (_Own("odd"), "of the stream: _Own: odd (test_feeding.py, line"),
        (GeneratorExit(), "of the stream: GeneratorExit (test_feeding.py, line"),
    ],
)
def test_any_error_of_a_detector_is_its_failure(error: BaseException, words: str) -> None:
    def fail(_: Any) -> None:
        raise error

    feed = feed_of("Good", push=fail)
    assert feed.feed(empty_events(), until_us=70) == []
    assert words in failure(feed)
    assert len(failure(feed)) < 500


def test_ctrl_c_is_not_a_failure_of_the_detector() -> None:
    def interrupted(_: Any) -> None:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as interrupt:  # as numba does
            raise SystemError("returned a result with an exception set") from interrupt

    def interrupted_directly(_: Any) -> None:
        raise KeyboardInterrupt

    for push, expected in ((interrupted, SystemError), (interrupted_directly, KeyboardInterrupt)):
        feed = feed_of("Good", push=push)
        with pytest.raises(expected):
            feed.feed(empty_events(), until_us=70)
        assert feed.failure is None


@pytest.mark.parametrize("error", [MemoryBudgetError("A surface needs 9 GB."), MemoryError()])
def test_too_little_memory_is_not_a_failure_of_the_detector(error: Exception) -> None:
    def growing(_: Any) -> None:
        raise error

    feed = feed_of("Good", push=growing)
    with pytest.raises(type(error)) as raised:
        feed.feed(empty_events(), until_us=70)
    assert raised.value is error
    assert feed.failure is None
