"""Scores of a method in a window."""

import numpy as np

from detector.estimate import MotionEstimate
from flybench.direction import Direction
from flybench.events import EVENT_DTYPE, Events, empty_events
from scenarios.detect.verdict import TOO_SHORT
from scenarios.validate.scoring import Score, Total, score
from scenarios.validate.stimulus import Stimulus
from scenarios.validate.turns import TURNS
from tests.scenarios.validate.made_recordings import HEIGHT, WIDTH, rightward, still

WINDOW = Stimulus(rightward(), (), WIDTH, HEIGHT, 300_000)
STILL = Stimulus(still(), (), WIDTH, HEIGHT, 300_000)


class Scripted:
    """Names a direction of a script every 10 ms: 30 none, then 4 up, then 6 right."""

    def __init__(self, **_size: int) -> None:
        self.steps = 0

    def push(self, _events: Events) -> list[MotionEstimate]:
        """Use no events."""
        return []

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Return the steps that are due."""
        before, self.steps = self.steps, t_us // 10_000
        script = [Direction.NONE] * 30 + [Direction.UP] * 4 + [Direction.RIGHT] * 6
        return [
            MotionEstimate(
                k * 10_000, 0.1, 0.0, script[k - 1], 0.1, (0.0, 0.0), (0.0, 0.0), (0, 0, 1, 1)
            )
            for k in range(before + 1, self.steps + 1)
        ]


def single_events(number: int) -> Events:
    """Return one event every ms."""
    events = np.zeros(number, EVENT_DTYPE)
    events["t"] = np.arange(number) * 1000
    return events


NAME = f"{__name__}:Scripted"


def test_steps_are_counted_to_the_end_of_the_window() -> None:
    window = Stimulus(empty_events(), (), WIDTH, HEIGHT, 400_000)
    assert score(NAME, window, Direction.RIGHT) == Score(
        Direction.RIGHT,
        steps=40,
        right=6,
        wrong=4,
        none=30,
        false_alarms=None,
        first_right_us=350_000,
        verdict="unclear",
    )


def test_where_nothing_moves_every_direction_is_a_false_alarm() -> None:
    window = Stimulus(empty_events(), (), WIDTH, HEIGHT, 400_000)
    found = score(NAME, window, Direction.NONE)
    assert (found.right, found.false_alarms) == (30, 10)
    assert (found.wrong, found.none, found.first_right_us) == (None, None, None)
    assert not found.verdict_is_right


def test_a_good_method_is_right_in_every_variant_of_made_motion() -> None:
    for turn in TURNS:
        found = score("fly", turn.stimulus(WINDOW), turn.direction(Direction.RIGHT))
        assert found.verdict_is_right, turn.name
        assert found.steps == 30
        assert found.right > 15
        assert found.wrong == 0
        assert found.first_right_us is not None
        assert 30_000 <= found.first_right_us <= 120_000


def test_noise_is_right_without_a_direction() -> None:
    found = score("fly", STILL, Direction.NONE)
    assert found.verdict == "nothing moves"
    assert found.verdict_is_right
    assert (found.right, found.false_alarms) == (30, 0)


def test_a_method_that_cannot_run_says_why() -> None:
    assert "needs APS frames" in score("frame-fly", WINDOW, Direction.RIGHT).note
    small = Stimulus(empty_events(), (), 10, 10, 1000)
    assert "The sensor is 10×10 px. Allowed is" in score("fly", small, Direction.RIGHT).note


class Failing(Scripted):
    """Raises an error after 340 ms."""

    def advance(self, t_us: int) -> list[MotionEstimate]:
        """Fail in the end."""
        if t_us > 340_000:
            raise ZeroDivisionError("no wind")
        return super().advance(t_us)


def test_a_detector_that_fails_keeps_its_counts_and_says_why_once() -> None:
    window = Stimulus(single_events(400), (), WIDTH, HEIGHT, 400_000)
    found = score(f"{__name__}:Failing", window, Direction.RIGHT)
    assert (found.steps, found.right, found.wrong, found.none) == (33, 0, 3, 30)
    assert found.note == ""
    assert found.failed.startswith("advance raised an error after 3")
    assert "ZeroDivisionError: no wind" in found.failed
    total = Total.of([found, found])
    assert (total.steps, total.right, total.verdicts, total.note) == (0, None, 0, found.failed)


def test_a_total_keeps_motion_and_stillness_apart() -> None:
    total = Total.of(
        [
            Score(Direction.UP, 10, 6, 1, 3, None, 40_000, "up"),
            Score(Direction.DOWN, 10, 2, 5, 3, None, 60_000, "up"),
            Score(Direction.UP, 10, 0, 0, 10, None, None, TOO_SHORT),
            Score(Direction.NONE, 10, 9, None, None, 1, None, "unclear"),
            Score(Direction.NONE, note="needs APS frames"),
        ]
    )
    assert total.steps == 40
    assert total.right == 17 / 40
    assert (total.wrong, total.none) == (6 / 30, 16 / 30)
    assert total.false_alarms == 0.1
    assert total.first_right_us == 50_000
    assert (total.right_verdicts, total.verdicts, total.too_short) == (1, 3, 1)
    assert total.note == ""


def test_a_total_without_a_run_holds_the_reasons() -> None:
    total = Total.of([Score(Direction.UP, note="a"), Score(Direction.UP, note="a")])
    assert (total.right, total.false_alarms, total.note) == (None, None, "a")


def test_the_detector_starts_with_the_window() -> None:
    """Events that begin late in a window leave its earlier steps in place."""
    late = rightward().copy()
    late["t"] += 200_000
    found = score("fly", Stimulus(late, (), WIDTH, HEIGHT, 500_000), Direction.RIGHT)
    assert found.steps == 50
