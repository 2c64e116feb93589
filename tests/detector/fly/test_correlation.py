import numpy as np
import numpy.typing as npt
import pytest

from detector.fly.correlation import DOWN, LEFT, RIGHT, UP, t4, t5
from detector.fly.model_variants import PairLocation

OFFSETS = (4, 8, 12, 16)
Surface = npt.NDArray[np.float32]


def surface(seed: int) -> Surface:
    return np.random.default_rng(seed).random((24, 30)).astype(np.float32)


def test_rightward_is_equation_9_at_the_midpoint() -> None:
    now, delayed = surface(0), surface(1)
    expected = np.zeros((24, 30))
    for i in OFFSETS:
        expected[:, i // 2 : 30 - i // 2] += delayed[:, : 30 - i] * now[:, i:]
    maps = t4(now, delayed, offsets=OFFSETS)
    np.testing.assert_allclose(maps[RIGHT], expected, rtol=1e-5)


def test_at_the_delayed_point_it_is_equation_9_as_printed() -> None:
    now, delayed = surface(0), surface(1)
    right, left, down = np.zeros((3, 24, 30))
    for i in OFFSETS:
        right[:, : 30 - i] += delayed[:, : 30 - i] * now[:, i:]
        left[:, i:] += delayed[:, i:] * now[:, : 30 - i]
        down[: 24 - i] += delayed[: 24 - i] * now[i:]
    maps = t4(now, delayed, offsets=OFFSETS, pair_location=PairLocation.DELAYED)
    for plane, expected in ((RIGHT, right), (LEFT, left), (DOWN, down)):
        np.testing.assert_allclose(maps[plane], expected, rtol=1e-5)


def test_an_offset_longer_than_the_grid_adds_nothing() -> None:
    now, delayed = surface(0), surface(1)
    for pair_location in PairLocation:
        alone = t4(now, delayed, offsets=(4,), pair_location=pair_location)
        more = t4(now, delayed, offsets=(4, 40, 61), pair_location=pair_location)
        np.testing.assert_array_equal(more, alone)


def test_a_midpoint_between_two_cells_gives_half_to_each() -> None:
    now, delayed = np.zeros((2, 9, 9), np.float32)
    delayed[4, 2], now[4, 5] = 2.0, 3.0
    maps = t4(now, delayed, offsets=(3,))
    assert maps[RIGHT, 4].tolist() == [0, 0, 0, 3, 3, 0, 0, 0, 0]
    assert maps.sum() == 6.0


@pytest.mark.parametrize("offsets", [(3, 6, 9), (4, 8, 12), (1, 2, 4)])
@pytest.mark.parametrize(("axis", "swapped"), [(1, [LEFT, RIGHT, UP, DOWN]), (0, [0, 1, 3, 2])])
def test_mirrored_surfaces_give_mirrored_maps(
    offsets: tuple[int, ...], axis: int, swapped: list[int]
) -> None:
    now, delayed = surface(5), surface(6)
    maps = t4(now, delayed, offsets=offsets)
    mirrored = t4(np.flip(now, axis), np.flip(delayed, axis), offsets=offsets)
    np.testing.assert_allclose(mirrored[swapped], np.flip(maps, axis + 1), rtol=1e-5)


def test_t5_correlates_like_t4() -> None:
    now, delayed = surface(0), surface(1)
    offsets = (2, 4, 6)
    np.testing.assert_array_equal(
        t4(now, delayed, offsets=offsets), t5(now, delayed, offsets=offsets)
    )


def test_transposed_surfaces_exchange_the_axes() -> None:
    now, delayed = surface(2), surface(3)
    upright = t4(now, delayed, offsets=(3, 6))
    lying = t4(np.ascontiguousarray(now.T), np.ascontiguousarray(delayed.T), offsets=(3, 6))
    np.testing.assert_array_equal(upright[DOWN], lying[RIGHT].T)
    np.testing.assert_array_equal(upright[UP], lying[LEFT].T)


def test_flicker_in_place_cancels() -> None:
    now = surface(4)
    flicker = t4(now, now * np.float32(0.5), offsets=OFFSETS)
    np.testing.assert_allclose(flicker[RIGHT], flicker[LEFT], rtol=1e-5)
    np.testing.assert_allclose(flicker[DOWN], flicker[UP], rtol=1e-5)


@pytest.mark.parametrize(
    ("shift", "winner"),
    [((0, 6), RIGHT), ((0, -6), LEFT), ((6, 0), DOWN), ((-6, 0), UP)],
)
def test_a_shifted_block_excites_its_direction_most(shift: tuple[int, int], winner: int) -> None:
    delayed = np.zeros((40, 40), np.float32)
    delayed[15:25, 15:25] = 1.0
    now = np.roll(delayed, shift, (0, 1))
    sums = t4(now, delayed, offsets=OFFSETS).sum(axis=(1, 2))
    assert int(np.argmax(sums)) == winner
