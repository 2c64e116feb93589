import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from detector.errors import StateError
from detector.fly.correlation import LEFT, RIGHT
from detector.fly.tangential import (
    DirectionSums,
    LeakyIntegrator,
    horizontal_system,
    lobula_plate,
    normalise,
    shares_of_total,
    signal_to_noise,
    vertical_system,
)


def test_lobula_plate_sums_only_over_the_region() -> None:
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


@given(st.tuples(*[st.floats(0, 1e300)] * 4))
def test_shares_stay_inside_the_open_interval(lp: tuple[float, float, float, float]) -> None:
    right, left, up, down = lp
    assert all(-1.0 < share < 1.0 for share in shares_of_total((right, left, up, down)))


def test_a_share_is_relative_to_both_directions() -> None:
    assert shares_of_total((5.0, 3.0, 3.0, 1.0)) == (0.25, -0.5)
    assert shares_of_total((0.0, 0.0, 0.0, 0.0)) == (0.0, 0.0)


def opponent_maps(right: list[float], left: list[float]) -> npt.NDArray[np.float32]:
    maps = np.zeros((4, 1, len(right)), np.float32)
    maps[RIGHT, 0], maps[LEFT, 0] = right, left
    return maps


def test_signal_to_noise_is_the_sum_over_the_root_of_the_power() -> None:
    maps = opponent_maps([5.0, 1.0, 9.0], [1.0, 3.0, 0.0])
    attended = np.array([[True, True, False]])
    horizontal, vertical = signal_to_noise(maps, attended)
    assert horizontal == pytest.approx(2 / math.sqrt(20))
    assert vertical == 0.0


def test_signal_to_noise_of_equal_cells_is_the_root_of_their_number() -> None:
    for number in (1, 16, 100):
        maps = opponent_maps([7.0] * number, [2.0] * number)
        ratio = signal_to_noise(maps, np.ones((1, number), np.bool_))[0]
        assert ratio == pytest.approx(math.sqrt(number))


def test_signal_to_noise_without_response_or_region_is_zero() -> None:
    maps = opponent_maps([7.0, 0.0], [2.0, 0.0])
    assert signal_to_noise(maps, np.array([[False, True]])) == (0.0, 0.0)
    assert signal_to_noise(maps, np.zeros((1, 2), np.bool_)) == (0.0, 0.0)


def test_signal_to_noise_of_random_signs_has_unit_variance() -> None:
    rng = np.random.default_rng(0)
    signs = rng.choice([-1.0, 1.0], (2000, 300)) * rng.exponential(1.0, (2000, 300))
    ratios = [
        signal_to_noise(opponent_maps(list(row), [0.0] * 300), np.ones((1, 300), np.bool_))[0]
        for row in signs
    ]
    assert np.mean(np.square(ratios)) == pytest.approx(1.0, abs=0.1)


def integrate(*sums: DirectionSums) -> list[DirectionSums]:
    integrator = LeakyIntegrator(time_constant_us=40_000, hop_us=10_000)
    return [integrator(lp) for lp in sums]


def test_the_low_pass_approaches_a_constant_by_its_time_constant() -> None:
    found = integrate(*[(8.0, 0.0, 2.0, 1.0)] * 4)
    expected = 8.0 * (1.0 - np.exp(-np.arange(1, 5) / 4.0))
    assert [lp[0] for lp in found] == pytest.approx(expected.tolist())


def test_a_short_surplus_of_another_direction_does_not_win() -> None:
    right, down = (3.0, 1.0, 1.0, 2.0), (2.0, 1.0, 1.0, 3.0)
    found = integrate(*[right] * 4, down)
    assert all(horizontal_system(lp) > vertical_system(lp) for lp in found)
    assert vertical_system(down) > horizontal_system(down)


def test_the_low_pass_rests_when_nothing_responds() -> None:
    silence, motion = (0.0, 0.0, 0.0, 0.0), (0.0, 5.0, 0.0, 0.0)
    found = integrate(motion, silence, motion)
    assert found[1] == silence
    assert found[2] == found[0]


def test_without_a_time_constant_the_sums_stay_as_they_are() -> None:
    integrator = LeakyIntegrator(time_constant_us=0, hop_us=10_000)
    for lp in ((5.0, 2.0, 1.0, 8.0), (1.0, 3.0, 0.0, 0.5)):
        assert integrator(lp) == lp


def test_negative_sums_of_a_state_are_refused() -> None:
    integrator = LeakyIntegrator(time_constant_us=40_000, hop_us=10_000)
    with pytest.raises(StateError, match="Allowed are 0 or more"):
        integrator.check({"sums": np.array([0.0, -1.0, 0.0, 0.0])})
