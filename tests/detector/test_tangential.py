import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from detector.estimate import Direction
from detector.tangential import (
    horizontal_system,
    lobula_plate,
    normalise,
    vertical_system,
    winner_take_all,
)


def test_lobula_plate_sums_only_the_region() -> None:
    maps = np.stack([np.full((3, 4), n, np.float32) for n in (1, 2, 3, 4)])
    attended = np.zeros((3, 4), np.bool_)
    attended[1, 1:3] = True
    assert lobula_plate(maps, attended) == (2.0, 4.0, 6.0, 8.0)


def test_rightward_and_downward_are_positive() -> None:
    lp = (5.0, 2.0, 1.0, 8.0)
    assert horizontal_system(lp) == 3.0
    assert vertical_system(lp) == 7.0


@given(st.floats(-1e300, 1e300))
def test_normalised_responses_stay_inside_the_open_interval(response: float) -> None:
    value = normalise(response, cells=100, scale=0.25)
    assert -1.0 < value < 1.0
    assert math.copysign(1.0, value) == math.copysign(1.0, response)


def test_normalisation_is_the_sigmoid_of_the_response_per_cell() -> None:
    expected = 2.0 / (1.0 + math.exp(-40.0 / (100 * 0.25))) - 1.0
    assert normalise(40.0, cells=100, scale=0.25) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("hs", "vs", "expected"),
    [
        (0.5, 0.4, Direction.RIGHT),
        (-0.5, 0.4, Direction.LEFT),
        (0.3, 0.4, Direction.DOWN),
        (0.3, -0.4, Direction.UP),
        (0.04, -0.04, Direction.NONE),
        (0.2, 0.2, Direction.RIGHT),
    ],
)
def test_the_stronger_system_wins_above_the_floor(
    hs: float, vs: float, expected: Direction
) -> None:
    assert winner_take_all(hs, vs, floor=0.05) is expected
