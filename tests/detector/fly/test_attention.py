import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from detector.fly.attention import (
    ViewCentre,
    delayed_steering,
    local_motion,
    most_salient,
    motion_at_centre,
    position_error,
    position_response,
    prominence,
    saliency_map,
    shift_towards,
    steering_response,
)
from detector.fly.config import FlyConfig
from detector.fly.correlation import DOWN, LEFT, RIGHT, UP

ROWS, COLUMNS = 87, 116
IMAGE_CENTRE = (57.0, 43.0)
NO_MOTION: npt.NDArray[np.float32] = np.zeros((4, ROWS, COLUMNS), np.float32)
finite = st.floats(-1e6, 1e6)


def one_salient_cell(x: int, y: int) -> npt.NDArray[np.float32]:
    saliency = np.zeros((ROWS, COLUMNS), np.float32)
    saliency[y, x] = 1.0
    return saliency


def view_centre() -> ViewCentre:
    return ViewCentre(FlyConfig(), grid=(ROWS, COLUMNS), image_centre=IMAGE_CENTRE)


def test_saliency_is_the_box_mean_of_both_pathways() -> None:
    rng = np.random.default_rng(0)
    on, off = rng.random((2, 9, 11)).astype(np.float32)
    padded = np.pad(on + off, 2)
    expected = np.array(
        [[padded[y : y + 5, x : x + 5].mean() for x in range(11)] for y in range(9)]
    )
    np.testing.assert_allclose(saliency_map(on, off, radius=2), expected, rtol=1e-5)


def test_most_salient_is_x_then_y_and_the_mean_of_equal_maxima() -> None:
    assert most_salient(one_salient_cell(70, 20) + 0.5 * one_salient_cell(10, 60)) == (70.0, 20.0)
    spot = saliency_map(one_salient_cell(70, 20), NO_MOTION[0], radius=3)
    assert most_salient(spot) == (70.0, 20.0)


def test_uniform_saliency_is_not_prominent() -> None:
    assert prominence(np.full((5, 5), 0.7, np.float32)) == pytest.approx(0.0, abs=1e-6)
    assert prominence(one_salient_cell(3, 3)) == pytest.approx(1.0, abs=1e-3)


def test_the_error_points_from_the_centre_to_the_target() -> None:
    assert position_error((10.0, 3.0), (4.0, 5.0)) == (6.0, -2.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_position_response_is_equation_12(sign: float) -> None:
    expected = sign * (math.exp((4 * 20 / 116) ** 2) - 1)
    assert position_response(sign * 20.0, side=116, cap=4.0) == pytest.approx(expected)


def test_position_response_is_capped_across_the_grid() -> None:
    assert position_response(115.0, side=116, cap=4.0) == pytest.approx(math.expm1(4.0))


def test_local_motion_is_the_opponent_share_near_the_centre() -> None:
    maps = NO_MOTION.copy()
    maps[RIGHT, 40, 50], maps[LEFT, 40, 50] = 3.0, 1.0
    maps[UP, 41, 51], maps[DOWN, 41, 51] = 2.0, 2.0
    maps[LEFT, 80, 100] = 50.0
    assert local_motion(maps, (50.0, 40.0), reach=5) == (0.25, 0.0)
    assert local_motion(maps, (10.0, 10.0), reach=5) == (0.0, 0.0)


def test_the_square_of_local_motion_is_symmetric() -> None:
    # Half a cell off the grid, where rounding would prefer one side.
    maps = NO_MOTION.copy()
    maps[RIGHT, 40, 48], maps[LEFT, 40, 53] = 1.0, 1.0
    assert local_motion(maps, (50.5, 40.0), reach=2.5) == (0.0, 0.0)
    assert local_motion(maps, (50.0, 40.0), reach=2.5) == (1.0, 0.0)


def test_motion_at_the_centre_is_equation_13_as_printed() -> None:
    maps = NO_MOTION.copy()
    maps[:, 41, 51] = 7.0, 3.0, 1.0, 6.0
    assert motion_at_centre(maps, (50.6, 41.4)) == (4.0, 5.0)
    assert motion_at_centre(maps, (-0.4, 90.0)) == (0.0, 0.0)


def test_steering_adds_motion_and_position_with_their_gains() -> None:
    assert steering_response(0.5, 0.2, g_m=5.0, g_p=30.0) == pytest.approx(8.5)


def test_steering_is_low_passed_only_while_it_keeps_its_sign() -> None:
    assert delayed_steering(4.0, 2.0, alpha=0.5) == 3.0
    assert delayed_steering(4.0, 0.0, alpha=0.5) == 2.0
    assert delayed_steering(-4.0, 2.0, alpha=0.5) == -4.0


@given(error=finite, steering=finite)
def test_a_shift_never_overshoots_or_moves_away(error: float, steering: float) -> None:
    shift = shift_towards(error, steering)
    assert min(error, 0.0) <= shift <= max(error, 0.0)


def test_the_view_centre_reaches_a_far_target_at_once_and_stays() -> None:
    centre = view_centre()
    for _ in range(3):
        centre.update(one_salient_cell(110, 5), NO_MOTION)
        assert centre.is_attending
    assert centre.position == (110.0, 5.0)


def test_the_view_centre_approaches_a_near_target_in_steps() -> None:
    centre = view_centre()
    distances = []
    for _ in range(12):
        centre.update(one_salient_cell(65, 43), NO_MOTION)
        distances.append(65.0 - centre.position[0])
    assert distances == sorted(distances, reverse=True)
    assert 0.0 <= distances[-1] < 0.5 * distances[0]


def test_the_low_pass_remembers_the_steering_before_clipping() -> None:
    moving = NO_MOTION.copy()
    moving[RIGHT] = 1.0
    centre = view_centre()
    lag = FlyConfig().window_hops
    for _ in range(lag):
        # On its target: the step is 0, while motion alone steers by α · g_m = 2.5.
        centre.update(one_salient_cell(57, 43), moving)
    assert centre.position == IMAGE_CENTRE
    centre.update(one_salient_cell(67, 43), moving)
    gamma = 5.0 + 30.0 * math.expm1((4 * 10 / 116) ** 2)
    assert centre.position[0] - IMAGE_CENTRE[0] == pytest.approx(0.5 * gamma + 0.5 * 2.5)


def test_motion_towards_the_target_speeds_up_the_approach() -> None:
    moving = NO_MOTION.copy()
    moving[RIGHT] = 1.0
    slow, fast = view_centre(), view_centre()
    slow.update(one_salient_cell(65, 43), NO_MOTION)
    fast.update(one_salient_cell(65, 43), moving)
    assert fast.position[0] > slow.position[0]


def test_the_view_centre_returns_to_the_image_centre_when_nothing_stands_out() -> None:
    centre = view_centre()
    centre.update(one_salient_cell(110, 5), NO_MOTION)
    centre.update(np.full((ROWS, COLUMNS), 0.4, np.float32), NO_MOTION)
    assert centre.position == IMAGE_CENTRE
    assert not centre.is_attending
