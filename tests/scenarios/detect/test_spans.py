"""Spans of time with one direction."""

from collections.abc import Sequence

from flybench.direction import Direction
from scenarios.detect.spans import Span, SpanFinder

WORDS = {
    "r": Direction.RIGHT,
    "l": Direction.LEFT,
    "u": Direction.UP,
    ".": Direction.NONE,
}


def spans(steps: str, *, step_us: int = 10_000, start_us: int = 0) -> Sequence[Span]:
    """Return the spans of one step for each letter."""
    finder = SpanFinder()
    for k, letter in enumerate(steps, start=1):
        finder.add(start_us + k * step_us, WORDS[letter], start_us=start_us)
    return finder.spans


def test_a_span_lasts_from_the_start_of_its_first_step_to_the_end_of_its_last() -> None:
    first, second = spans("..rrrrr....lllllll.", start_us=7_000_000)
    assert (first.direction, first.from_us, first.to_us) == (Direction.RIGHT, 7_020_000, 7_070_000)
    assert (second.direction, second.from_us, second.to_us) == (
        Direction.LEFT,
        7_110_000,
        7_180_000,
    )
    assert (first.steps, second.steps) == (5, 7)


def test_steps_that_cover_less_than_50_ms_are_no_span() -> None:
    assert spans("rrrr.") == []
    assert [span.steps for span in spans("rrrrr.")] == [5]
    assert spans("r" + "." * 9 + "r") == []  # 20 ms of 110
    assert [span.steps for span in spans("r", step_us=50_000)] == [1]


def test_a_step_in_another_direction_or_100_ms_without_one_ends_a_span() -> None:
    assert [span.steps for span in spans("rrrrr" + "." * 10 + "rrrrr")] == [10]
    assert [span.steps for span in spans("rrrrr" + "." * 11 + "rrrrr")] == [5, 5]
    assert [span.steps for span in spans("rrrrrurrrrr")] == [5, 5]
    assert [span.steps for span in spans("rrr", step_us=250_000)] == [3]  # slow frames


def test_a_pause_ends_a_span_and_belongs_to_no_step() -> None:
    finder = SpanFinder()
    for t_us in (50_000, 60_000, 5_000_000, 5_060_000):
        finder.add(t_us, Direction.UP, start_us=0)
    assert [(span.from_us, span.to_us, span.covered_us) for span in finder.spans] == [
        (0, 60_000, 60_000),
        (5_000_000, 5_060_000, 60_000),
    ]
