"""The verdict on a recording."""

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from detector.estimate import MotionEstimate
from flybench.direction import Direction
from flybench.events import empty_events
from scenarios.detect import spans, verdict
from scenarios.detect.run_detector import RecordingSlice
from scenarios.detect.verdict import RecordingVerdict, memory_us
from scenarios.errors import MethodError
from scenarios.pipeline.registry import DETECTORS

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "detect.md"
WORDS = {"r": "right", "l": "left", "u": "up", "d": "down", ".": "none"}


def judged(steps: str, *, memory_us: int = 0, start_us: int = 0) -> RecordingVerdict:
    """Judge one step of 10 ms for each letter."""
    found = RecordingVerdict(memory_us)
    for k, letter in enumerate(steps, start=1):
        t_us, direction = start_us + k * 10_000, Direction(WORDS[letter])
        step = MotionEstimate(t_us, 0.1, 0.1, direction, 0.1, (0.0, 0.0), (0.0, 0.0), None)
        found.add(RecordingSlice(empty_events(), (), (step,), None, start_us))
    return found


@pytest.mark.parametrize(
    ("steps", "word"),
    [
        ("." * 10 + "l" * 40, "left"),
        ("l" * 8 + "u" * 2, "left"),  # 80 %
        ("l" * 7 + "u" * 2, "unclear"),  # 78 %, one span
        ("r" * 20 + "." * 30 + "l" * 15, "changes"),
        ("." * 58, "nothing moves"),
        ("." * 198 + "rd", "nothing moves"),  # 1 %
        ("." * 56 + "rr", "unclear"),  # 2 of 58
        ("." * 400 + "rrrrr", "right"),  # 1.2 %, but 50 ms at a stretch
        ("." * 600 + "rrrrr", "right"),  # 0.8 %, but 50 ms at a stretch
        ("r.l.u." * 10, "unclear"),
        ("", "too short to judge"),
    ],
)
def test_the_verdict_follows_the_steps(steps: str, word: str) -> None:
    found = judged(steps)
    assert found.word == word
    assert found.direction == (word if word in WORDS.values() else "none")


def test_two_of_58_steps_are_said_to_be_two_of_58() -> None:
    found = judged("." * 56 + "rr")
    assert found.reason == (
        "2 of 58 steps name a direction, 2 of these right, and none holds for 0.05 s"
    )
    assert found.shares[Direction.RIGHT] == pytest.approx(2 / 58)
    assert found.shares[Direction.NONE] == pytest.approx(56 / 58)
    assert sum(found.shares.values()) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (0.0, "0 %"),
        (0.001, "< 1 %"),
        (0.006, "1 %"),
        (0.994, "99 %"),
        (0.999, "> 99 %"),
        (1.0, "100 %"),
    ],
)
def test_only_all_steps_are_100_percent(share: float, text: str) -> None:
    assert verdict.percent(share) == text


def test_a_recording_shorter_than_the_memory_is_too_short() -> None:
    assert judged("l" * 9, memory_us=100_000, start_us=5_000_000).word == "too short to judge"
    assert judged("l" * 10, memory_us=100_000, start_us=5_000_000).word == "left"
    assert judged("l" * 9, memory_us=100_000).reason == (
        "9 of 9 steps name a direction; 0.09 s long, the method looks back 0.1 s"
    )


def test_json_lists_shares_spans_and_limits() -> None:
    document = json.loads(json.dumps(judged("rrrrr...llllll").to_json()))
    assert document["verdict"] == "changes"
    assert document["direction"] == "none"
    assert document["share"] == 6 / 11
    assert document["counts"] == {"right": 5, "left": 6, "up": 0, "down": 0, "none": 3}
    assert document["spans"] == [
        {"direction": "right", "from_us": 0, "to_us": 50_000, "steps": 5},
        {"direction": "left", "from_us": 80_000, "to_us": 140_000, "steps": 6},
    ]
    assert document["limits"]["least_share"] == 0.8


@pytest.mark.parametrize(
    ("method", "expected_us"),
    [
        ("fly", 100_000),
        ("wide", 250_000),
        ("robust", 90_000),  # its low-pass does not count
        ("frame-fly", 200_000),
        ("contrast-maximisation", 50_000),
        ("plane-fit", 150_000),
    ],
)
def test_a_detector_states_how_far_it_looks_back(method: str, expected_us: int) -> None:
    assert memory_us(DETECTORS[method].make(width=346, height=260)) == expected_us


@pytest.mark.parametrize("value", [-1, 0.5, "100", None, True])
def test_a_memory_that_is_no_time_is_refused(value: Any) -> None:
    detector: Any = SimpleNamespace(memory_us=value)
    with pytest.raises(MethodError, match=re.escape(f"memory_us is {value!r}. Allowed is")):
        memory_us(detector)
    unknown: Any = SimpleNamespace()
    assert memory_us(unknown) == 0


def test_the_documentation_states_the_limits() -> None:
    text = PAGE.read_text(encoding="utf-8")
    limits = text[text.index("## The verdict") :]
    for limit in (
        f"verdict | {verdict.LEAST_SHARE:.0%}".replace("%", " %"),
        f"moves | {verdict.STILL_SHARE:.0%}".replace("%", " %"),
        f"least | {spans.LEAST_SPAN_US // 1000} ms",
        f"most | {spans.GAP_US // 1000} ms",
        f"pause | {spans.PAUSE_US // 1_000_000} s",
    ):
        assert limit in limits
