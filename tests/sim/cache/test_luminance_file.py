"""The file of light: what is written comes back, and anything else is known before it is used."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from sim.cache.luminance_file import DamagedError, Light, LuminanceWriter, read_luminance
from tests.sim.lights import KEY, OTHER, SHAPE, lights, same


@pytest.fixture
def path(tmp_path: Path) -> Path:
    with (tmp_path / "light").open("wb") as file:
        writer = LuminanceWriter(file, KEY)
        for light in lights():
            writer.write(light)
    assert writer.written == (tmp_path / "light").stat().st_size
    return tmp_path / "light"


def read(path: Path, key: str = KEY, count: int = 4) -> list[Light]:
    with path.open("rb") as file:
        return list(read_luminance(file, key, SHAPE, count))


def right_before_damage(path: Path) -> int:
    """How many samples are given before damage is known; all of them must be right."""
    seen: list[Light] = []
    with path.open("rb") as file, pytest.raises(DamagedError):
        seen.extend(read_luminance(file, KEY, SHAPE, 4))  # keeps what came before
    return len(seen)


def test_what_is_written_comes_back(path: Path) -> None:
    assert same(iter(read(path)), lights())


def test_values_that_no_arithmetic_would_bring_back_do(tmp_path: Path) -> None:
    odd = [np.nan, np.inf, -np.inf, -0.0, 1e-45, 3.4e38, 0.0]
    frames = [np.array([odd[k:] + odd[:k]], np.float32) for k in range(len(odd))]
    written = [
        Light(k, f, np.full(f.shape, -1, np.int32), (0, 0, 7, 1)) for k, f in enumerate(frames)
    ]
    with (tmp_path / "odd").open("wb") as file:
        writer = LuminanceWriter(file, KEY)
        for light in written:
            writer.write(light)
    with (tmp_path / "odd").open("rb") as file:
        assert same(read_luminance(file, KEY, (1, 7), len(odd)), iter(written))


def test_samples_own_their_arrays(path: Path) -> None:
    with path.open("rb") as file:
        for light, drawn in zip(read_luminance(file, KEY, SHAPE, 4), lights(), strict=True):
            assert np.array_equal(light.luminance, drawn.luminance)
            assert np.array_equal(light.body, drawn.body)
            light.luminance[:] = 0
            light.body[:] = 0


def test_what_the_caller_does_to_a_sample_is_not_written(tmp_path: Path) -> None:
    with (tmp_path / "light").open("wb") as file:
        writer = LuminanceWriter(file, KEY)
        for light in lights():
            writer.write(light)
            light.luminance[:] = 0
    assert same(iter(read(tmp_path / "light")), lights())


def test_another_key_or_more_samples_than_there_are_is_damage(path: Path) -> None:
    with pytest.raises(DamagedError):
        read(path, key=OTHER)
    with pytest.raises(DamagedError):
        read(path, count=5)


def test_a_cut_anywhere_is_known(path: Path) -> None:
    whole = path.read_bytes()
    found = []
    for size in range(len(whole)):
        path.write_bytes(whole[:size])
        found.append(right_before_damage(path))
    assert found == sorted(found)
    assert set(found) == {0, 1, 2, 3}


def test_a_flip_anywhere_is_known_before_it_shows(path: Path) -> None:
    whole = path.read_bytes()
    drawn = list(lights())
    for place, bit in itertools.product(range(len(whole)), (0, 7)):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << bit
        path.write_bytes(damaged)
        seen: list[Light] = []
        with path.open("rb") as file, pytest.raises(DamagedError):
            seen.extend(read_luminance(file, KEY, SHAPE, 4))
        assert same(iter(seen), iter(drawn[: len(seen)]))


def test_records_that_changed_places_are_known(path: Path) -> None:
    """Each is right in itself; their order is not."""
    with (path.parent / "longer").open("wb") as file:
        writer = LuminanceWriter(file, KEY)
        ends = [0]
        for light in lights():
            writer.write(light)
            ends.append(writer.written)
    whole = (path.parent / "longer").read_bytes()
    parts = [whole[a:b] for a, b in itertools.pairwise(ends)]
    path.write_bytes(b"".join([parts[0], parts[2], parts[1], parts[3]]))
    assert right_before_damage(path) == 1
