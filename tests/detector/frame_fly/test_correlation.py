import numpy as np
import pytest

from detector.frame_fly.correlation import (
    block_signal_to_noise,
    block_sums,
    delayed,
    opponent_motion,
    smoothed,
    tangential_response,
)


def point(x: int, y: int) -> np.ndarray:
    image = np.zeros((9, 11), np.float32)
    image[y, x] = 1.0
    return image


def test_the_delay_mixes_two_frames() -> None:
    now, before = np.ones((1, 1), np.float32), np.zeros((1, 1), np.float32)
    late = delayed(now, before, interval_us=25_000, tau_us=75_000)
    assert late[0, 0] == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("now", "before", "expected"),
    [
        ((6, 4), (4, 4), (1, 0)),
        ((4, 4), (6, 4), (-1, 0)),
        ((5, 5), (5, 3), (0, 1)),
        ((5, 3), (5, 5), (0, -1)),
        ((7, 4), (4, 4), (0, 0)),
    ],
)
def test_a_step_of_one_distance_gives_a_response_in_its_direction(
    now: tuple[int, int], before: tuple[int, int], expected: tuple[int, int]
) -> None:
    motion = opponent_motion(
        point(*now), point(*before), interval_us=100_000, offsets=(2,), delays_us=(100_000,)
    )
    np.testing.assert_allclose(motion.sum(axis=(1, 2)), 0.5 * np.array(expected), atol=1e-7)


def test_a_pair_belongs_to_its_midpoint() -> None:
    motion = opponent_motion(
        point(6, 4), point(4, 4), interval_us=100_000, offsets=(2,), delays_us=(100_000,)
    )
    assert np.argwhere(motion[0]).tolist() == [[4, 5]]


def test_a_still_image_gives_no_response() -> None:
    image = np.random.default_rng(0).random((9, 11)).astype(np.float32)
    motion = opponent_motion(
        image, image, interval_us=25_000, offsets=(2, 4), delays_us=(200_000, 160_000)
    )
    np.testing.assert_allclose(motion, 0.0, atol=1e-6)


def test_a_distance_longer_than_the_image_adds_nothing() -> None:
    motion = opponent_motion(
        point(6, 4), point(4, 4), interval_us=100_000, offsets=(50,), delays_us=(100_000,)
    )
    assert not motion.any()


def test_smoothing_weights_present_and_past() -> None:
    now, before = np.ones((1, 1), np.float32), np.full((1, 1), 11.0, np.float32)
    assert smoothed(now, before, weight=0.9)[0, 0] == pytest.approx(2.0)


def test_the_tangential_response_is_the_printed_sigmoid() -> None:
    printed = 1.0 / (1.0 + np.exp(-3.0 / (100 * 0.01))) - 0.5
    assert tangential_response(3.0, cells=100, scale=0.01) == pytest.approx(printed)
    assert tangential_response(-3.0, cells=100, scale=0.01) == pytest.approx(-printed)
    assert tangential_response(1e9, cells=100, scale=0.01) < 0.5


def test_signal_to_noise_is_one_for_one_block_and_grows_with_agreement() -> None:
    motion = np.zeros((2, 20, 20), np.float32)
    motion[0, 3, 3] = 7.0
    motion[1, ::5, ::5] = 2.0
    assert block_signal_to_noise(block_sums(motion, side=5)) == pytest.approx((1.0, 4.0))
    assert block_signal_to_noise(np.zeros((2, 2, 2))) == (0.0, 0.0)


def test_blocks_at_the_edge_are_smaller() -> None:
    motion = np.random.default_rng(0).random((3, 7, 12)).astype(np.float32)
    sums = block_sums(motion, side=5)
    assert sums.shape == (3, 2, 3)
    expected = [[m[a : a + 5, b : b + 5].sum() for b in (0, 5, 10)] for m in motion for a in (0, 5)]
    np.testing.assert_allclose(sums.reshape(6, 3), expected, rtol=1e-6)
