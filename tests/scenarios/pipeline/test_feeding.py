"""Feeding a detector and checking its estimates."""

import numpy as np
import pytest

from emulator import ApsFrame
from flybench.events import empty_events
from scenarios.errors import MethodError
from scenarios.pipeline.feeding import feed
from scenarios.pipeline.user_detectors import find_method
from tests.scenarios.timed_events import events_at

pytestmark = pytest.mark.usefixtures("user_modules")


def test_events_are_pushed_and_time_is_advanced() -> None:
    detector = find_method("some_detectors:Good").make(width=346, height=260)
    (estimate,) = feed(detector, empty_events(), until_us=70)
    assert estimate.t_us == 70


def test_a_frame_is_passed_between_the_events_before_and_after_it() -> None:
    logger = find_method("some_detectors:FrameLogger").make(width=346, height=260)
    frames = [ApsFrame(0, end, np.full((2, 2), end, np.uint16)) for end in (20, 30)]
    feed(logger, events_at(10, 19, 20, 40), until_us=50, frames=frames)
    assert logger.received == [10, 19, (20, 20), 20, (30, 30), 40]  # type: ignore[attr-defined]
    without = find_method("some_detectors:Good").make(width=346, height=260)
    assert len(feed(without, events_at(10), until_us=50, frames=frames)) == 1


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
    detector = find_method(f"some_detectors:{name}").make(width=346, height=260)
    events, image = events_at(10, 19), np.full((2, 2), 7, np.uint16)
    with pytest.raises(MethodError, match=rf"{name}\.{call} writes into an array .*Copy first"):
        feed(detector, events, until_us=50, frames=[ApsFrame(0, 20, image)])
    assert events["t"].tolist() == [10, 19]
    assert (image == 7).all()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("NoList", r"NoList\.advance returned NoneType"),
        ("ListOfStrings", "a list of str"),
        (
            "RepeatedTime",
            r"RepeatedTime returned an estimate at 20 µs after one at 20 µs\. Allowed",
        ),
        ("Backwards", "an estimate at 10 µs after one at 20 µs"),
        ("NotANumber", r"NotANumber\.advance .* an estimate at 20 µs whose hs is nan\. Allowed"),
        ("Infinite", r"whose response is \(inf, 0.0\)"),
        ("NoResponse", "whose response is None"),
        ("DirectionAsString", r"whose direction is 'right'\. Allowed is a detector\.Direction"),
        ("HalfBox", r"whose roi_px is \(3, 4\)\. Allowed is"),
        ("LargeHs", r"whose hs is 5\.0\. Allowed is a number from -1 to 1"),
        ("LargeStrength", r"whose strength is 7\.0\. Allowed is a number from 0 to 1"),
        ("ScalarResponse", r"whose response is 0\.5\. Allowed are two numbers"),
        ("InvertedBox", r"whose roi_px is \(9, 9, 1, 1\)\. Allowed is .*x0 < x1"),
    ],
)
def test_an_invalid_estimate_is_refused(name: str, words: str) -> None:
    detector = find_method(f"some_detectors:{name}").make(width=346, height=260)
    with pytest.raises(MethodError, match=words):
        feed(detector, empty_events(), until_us=70)


def test_estimates_must_be_later_than_those_of_earlier_calls() -> None:
    detector = find_method("some_detectors:Good").make(width=346, height=260)
    estimates = feed(detector, empty_events(), until_us=70)
    estimates += feed(detector, empty_events(), until_us=80, earlier=estimates)
    assert [e.t_us for e in estimates] == [70, 80]
    with pytest.raises(MethodError, match="at 80 µs after one at 80 µs"):
        feed(detector, empty_events(), until_us=80, earlier=estimates)
