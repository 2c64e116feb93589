"""Changes between codes, packed and added again."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.cache.packing import add_change, max_bytes, pack_change

U8 = npt.NDArray[np.uint8]
U32 = npt.NDArray[np.uint32]
ROW_HEAD = 2
"""Bytes before the tags of a short row."""


def codes(seed: int, shape: tuple[int, int] = (5, 9)) -> U32:
    return np.random.default_rng(seed).integers(0, 1 << 32, shape, np.uint32)


def changed(before: U32, change: npt.ArrayLike) -> U32:
    return before + np.asarray(change, np.int64).astype(np.uint32)


def packed(now: U32, before: U32) -> U8:
    """Pack the changes, and set `before` to `now`."""
    data = np.full(max_bytes(now), 255, np.uint8)
    return data[: pack_change(now, before, data, 0)]


@pytest.mark.parametrize("columns", [1, 3, 4, 9, 346, 1280, 70_000])
def test_unpacking_restores_the_codes(columns: int) -> None:
    writer, reader = (np.zeros((3, columns), np.uint32) for _ in range(2))
    for seed in range(3):
        now = codes(seed, (3, columns))
        data = packed(now, writer)
        assert add_change(reader, data, 0) == len(data)
        assert np.array_equal(writer, now)
        assert np.array_equal(reader, now)


def test_a_rectangle_is_packed_alone() -> None:
    writer, reader, now = codes(0), codes(0), codes(1)
    rectangle = np.s_[1:4, 2:7]
    add_change(reader[rectangle], packed(now[rectangle], writer[rectangle]), 0)
    expected = codes(0)
    expected[rectangle] = now[rectangle]
    assert np.array_equal(reader, expected)
    assert np.array_equal(writer, expected)


def test_changes_are_packed_behind_others() -> None:
    first, second = np.zeros((2, 9), np.uint32), np.zeros((3, 9), np.uint32)
    data = np.zeros(max_bytes(first) + max_bytes(second), np.uint8)
    middle = pack_change(codes(0, (2, 9)), first.copy(), data, 0)
    end = pack_change(codes(1, (3, 9)), second.copy(), data, middle)
    assert add_change(first, data[:end], 0) == middle
    assert add_change(second, data[:end], middle) == end
    assert np.array_equal(first, codes(0, (2, 9)))
    assert np.array_equal(second, codes(1, (3, 9)))


@pytest.mark.parametrize(
    ("change", "size"),
    [
        (1, 2),
        (-1, 2),
        ((1 << 15) - 1, 2),
        (-(1 << 15), 2),
        (1 << 15, 3),
        (-(1 << 15) - 1, 3),
        ((1 << 23) - 1, 3),
        (-(1 << 23), 3),
        (1 << 23, 4),
        ((1 << 31) - 1, 4),
        (-(1 << 31), 4),
    ],
)
def test_a_change_takes_as_few_bytes_as_possible(change: int, size: int) -> None:
    before = codes(0, (1, 11))
    now = changed(before, [[0, 0, 0, 0, 0, 0, 0, change, change, 0, 0]])
    tags = 2
    data = packed(now, before.copy())
    assert len(data) == ROW_HEAD + tags + 2 * size
    add_change(before, data, 0)
    assert np.array_equal(before, now)


def test_a_row_without_changes_takes_one_byte() -> None:
    assert len(packed(codes(0), codes(0))) == len(codes(0))


@pytest.mark.parametrize("columns", [1, 4, 9, 700])
def test_no_change_takes_more_bytes_than_the_maximum(columns: int) -> None:
    before = np.zeros((2, columns), np.uint32)
    assert len(packed(before + np.uint32(1 << 31), before.copy())) <= max_bytes(before)


def test_bytes_that_were_cut_are_refused() -> None:
    data = packed(codes(1), codes(0))
    for size in range(len(data)):
        assert add_change(codes(0), data[:size], 0) == -1


@pytest.mark.parametrize("seed", range(200))
def test_arbitrary_bytes_change_nothing_outside(seed: int) -> None:
    whole = codes(0, (9, 20))
    data = np.random.default_rng(seed).integers(0, 256, 200, np.uint8)
    data[np.random.default_rng(seed + 1).random(200) < 0.5] //= 64  # short rows are read further
    assert -1 <= add_change(whole[2:7, 5:12], data, 0) <= len(data)
    untouched = np.ones(whole.shape, np.bool_)
    untouched[2:7, 5:12] = False
    assert np.array_equal(whole[untouched], codes(0, (9, 20))[untouched])
