"""Mirrored and turned windows."""

import numpy as np
import pytest

from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import EVENT_DTYPE
from scenarios.validate.stimulus import Stimulus
from scenarios.validate.turns import TURNS, Turn
from tests.detector.stimuli import turned
from tests.scenarios.validate.made_recordings import HEIGHT, WIDTH, rightward


def marked() -> Stimulus:
    """Return an event and a bright pixel of a frame at x = 5, y = 1 on a sensor of 7×4 px."""
    events = np.zeros(1, EVENT_DTYPE)
    events["x"], events["y"] = 5, 1
    image = np.zeros((4, 7), np.uint16)
    image[1, 5] = 100
    return Stimulus(events, (ApsFrame(0, 10, image),), 7, 4, 1000)


@pytest.mark.parametrize(
    ("turn", "place", "size"),
    [
        (TURNS[0], (5, 1), (7, 4)),
        (TURNS[1], (1, 1), (7, 4)),
        (TURNS[2], (2, 5), (4, 7)),
        (TURNS[3], (1, 2), (7, 4)),
        (TURNS[4], (1, 1), (4, 7)),
    ],
)
def test_events_and_frames_turn_together(
    turn: Turn, place: tuple[int, int], size: tuple[int, int]
) -> None:
    found = turn.stimulus(marked())
    assert (found.width, found.height) == size
    assert (found.events["x"][0], found.events["y"][0]) == place
    image = found.frames[0].image
    assert image.shape == (size[1], size[0])
    assert image[place[1], place[0]] == 100


def test_a_turn_does_not_change_its_input() -> None:
    before = marked()
    for turn in TURNS:
        turn.stimulus(before)
    assert np.array_equal(before.events, marked().events)


@pytest.mark.parametrize("direction", list(Direction))
def test_every_direction_of_motion_becomes_each_of_the_four(direction: Direction) -> None:
    quarters = [TURNS[0], *TURNS[2:]]
    expected = {Direction.NONE} if direction is Direction.NONE else set(Direction) - {"none"}
    assert {turn.direction(direction) for turn in quarters} == expected
    vertical = direction not in (Direction.LEFT, Direction.RIGHT)
    assert (TURNS[1].direction(direction) is direction) is vertical


def test_the_directions_agree_with_those_of_other_stimuli() -> None:
    """`turned` of the detectors' tests turns the same motion in another way."""
    whole = Stimulus(rightward(), (), WIDTH, HEIGHT, 300_000)
    assert TURNS[2].direction(Direction.RIGHT) is Direction.DOWN
    down = turned(rightward(), Direction.DOWN, width=WIDTH, height=HEIGHT)
    found = TURNS[2].stimulus(whole).events
    assert np.array_equal(found["y"], down["y"])
    left = turned(rightward(), Direction.LEFT, width=WIDTH, height=HEIGHT)
    assert np.array_equal(TURNS[1].stimulus(whole).events, left)
