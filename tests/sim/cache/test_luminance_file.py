"""The luminance file: what is written is read back, and damage is detected before use."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from sim.cache.luminance_file import (
    DamagedError,
    LuminanceSample,
    LuminanceWriter,
    read_luminance,
)
from tests.sim.luminance_samples import KEY, OTHER_KEY, SHAPE, equal, samples


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "luminance"
    with path.open("wb") as file:
        writer = LuminanceWriter(file, KEY)
        for sample in samples():
            writer.write(sample)
    assert writer.written == path.stat().st_size
    return path


def read(path: Path, key: str = KEY, count: int = 4) -> list[LuminanceSample]:
    with path.open("rb") as file:
        return list(read_luminance(file, key, SHAPE, count))


def read_until_damage(path: Path) -> list[LuminanceSample]:
    """Return the samples that are read before damage is detected."""
    found: list[LuminanceSample] = []
    with path.open("rb") as file, pytest.raises(DamagedError):
        found.extend(read_luminance(file, KEY, SHAPE, 4))
    return found


def test_samples_are_read_back(path: Path) -> None:
    assert equal(iter(read(path)), samples())


def test_special_floating_point_values_are_read_back(tmp_path: Path) -> None:
    odd = [np.nan, np.inf, -np.inf, -0.0, 1e-45, 3.4e38, 0.0]
    frames = [np.array([odd[k:] + odd[:k]], np.float32) for k in range(len(odd))]
    written = [
        LuminanceSample(k, f, np.full(f.shape, -1, np.int32), (0, 0, 7, 1))
        for k, f in enumerate(frames)
    ]
    with (tmp_path / "odd").open("wb") as file:
        writer = LuminanceWriter(file, KEY)
        for sample in written:
            writer.write(sample)
    with (tmp_path / "odd").open("rb") as file:
        assert equal(read_luminance(file, KEY, (1, 7), len(odd)), iter(written))


def test_samples_own_their_arrays(path: Path) -> None:
    with path.open("rb") as file:
        for sample, written in zip(read_luminance(file, KEY, SHAPE, 4), samples(), strict=True):
            assert np.array_equal(sample.luminance, written.luminance)
            assert np.array_equal(sample.body, written.body)
            sample.luminance[:] = 0
            sample.body[:] = 0


def test_later_changes_to_a_written_sample_have_no_effect(tmp_path: Path) -> None:
    path = tmp_path / "luminance"
    with path.open("wb") as file:
        writer = LuminanceWriter(file, KEY)
        for sample in samples():
            writer.write(sample)
            sample.luminance[:] = 0
    assert equal(iter(read(path)), samples())


def test_a_wrong_key_or_too_few_samples_are_damage(path: Path) -> None:
    with pytest.raises(DamagedError):
        read(path, key=OTHER_KEY)
    with pytest.raises(DamagedError):
        read(path, count=5)


def test_truncation_anywhere_is_detected(path: Path) -> None:
    whole = path.read_bytes()
    counts = []
    for size in range(len(whole)):
        path.write_bytes(whole[:size])
        counts.append(len(read_until_damage(path)))
    assert counts == sorted(counts)
    assert set(counts) == {0, 1, 2, 3}


def test_a_flipped_bit_anywhere_is_detected_before_its_sample_is_used(path: Path) -> None:
    whole = path.read_bytes()
    written = list(samples())
    for place, bit in itertools.product(range(len(whole)), (0, 7)):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << bit
        path.write_bytes(damaged)
        found = read_until_damage(path)
        assert equal(iter(found), iter(written[: len(found)]))


def test_swapped_records_are_detected(path: Path) -> None:
    """Each record is undamaged, but their order is wrong."""
    with (path.parent / "longer").open("wb") as file:
        writer = LuminanceWriter(file, KEY)
        ends = [0]
        for sample in samples():
            writer.write(sample)
            ends.append(writer.written)
    whole = (path.parent / "longer").read_bytes()
    parts = [whole[a:b] for a, b in itertools.pairwise(ends)]
    path.write_bytes(b"".join([parts[0], parts[2], parts[1], parts[3]]))
    assert len(read_until_damage(path)) == 1
