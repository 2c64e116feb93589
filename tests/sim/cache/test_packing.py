"""Changes between codes, packed and added again."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.cache.packing import add_change, pack_change, tags_shape

U32 = npt.NDArray[np.uint32]


def codes(seed: int, shape: tuple[int, int, int] = (2, 5, 9)) -> U32:
    return np.random.default_rng(seed).integers(0, 1 << 32, shape, np.uint32)


def changed(before: U32, change: npt.ArrayLike) -> U32:
    return before + np.asarray(change, np.int64).astype(np.uint32)


def test_unpacking_restores_the_codes() -> None:
    writer, reader = (np.zeros((2, 5, 9), np.uint32) for _ in range(2))
    for seed in range(3):
        now = codes(seed)
        tags, data = pack_change(now, writer)
        add_change(reader, tags, data)
        assert np.array_equal(writer, now)
        assert np.array_equal(reader, now)


def test_a_rectangle_is_packed_alone() -> None:
    writer, reader, now = codes(0), codes(0), codes(1)
    rectangle = np.s_[:, 1:4, 2:7]
    add_change(reader[rectangle], *pack_change(now[rectangle], writer[rectangle]))
    expected = codes(0)
    expected[rectangle] = now[rectangle]
    assert np.array_equal(reader, expected)
    assert np.array_equal(writer, expected)


@pytest.mark.parametrize(
    ("change", "size"),
    [
        (0, 0),
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
    before = codes(0, (1, 1, 5))
    now = changed(before, [[[0, 0, 0, change, change]]])
    tags, data = pack_change(now, before.copy())
    assert tags.shape == tags_shape(now) == (1, 1, 2)
    assert len(data) == 2 * size
    add_change(before, tags, data)
    assert np.array_equal(before, now)


def test_tags_and_bytes_that_do_not_match_are_refused() -> None:
    tags, data = pack_change(codes(1), codes(0))
    for wrong in ((tags, data[:-1]), (tags[:1], data), (np.zeros_like(tags), data)):
        untouched = codes(0)
        with pytest.raises(ValueError, match="do not match"):
            add_change(untouched, *wrong)
        assert np.array_equal(untouched, codes(0))


def test_tags_beyond_the_last_column_change_nothing_else() -> None:
    whole = codes(0)
    part = whole[:, :, :6]  # two tags of each row's second byte are unused
    tags = np.zeros(tags_shape(part), np.uint8)
    tags[:, :, 1] = 1 << 4
    add_change(part, tags, np.ones(2 * 10, np.uint8))
    assert np.array_equal(whole, codes(0))
