"""The cache of light: drawn once, bounded, shared, never wrong, whatever becomes of its files."""

import multiprocessing
import os
import resource
import signal
import subprocess
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim import Crossing, CrossingConfig, Lighting, SimError
from sim import crossing as crossing_module
from sim.cache.luminance_cache import LOCK, LuminanceCache, LuminanceStream
from sim.cache.luminance_file import Light
from sim.errors import RendererError
from tests.sim.lights import KEY, OTHER, SHAPE, lights, same

COUNT = 4


def refuse(sentence: str) -> None:
    raise AssertionError(sentence)


def cache(folder: Path, **options: Any) -> LuminanceCache:
    return LuminanceCache(folder, **({"warn": refuse} | options))


def never() -> LuminanceStream:
    raise AssertionError("drawn")
    yield


def entry(folder: Path, key: str = KEY) -> Path:
    return folder / f"{key}.light"


def fill(folder: Path, key: str = KEY, **options: Any) -> LuminanceCache:
    it = cache(folder, **options)
    assert same(it.light(key, SHAPE, COUNT, lights), lights())
    return it


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} - {LOCK}


def test_a_sequence_is_drawn_once(tmp_path: Path) -> None:
    it = fill(tmp_path / "made" / "when needed")
    assert (it.found, it.drawn) == (0, COUNT)
    assert same(it.light(KEY, SHAPE, COUNT, never), lights())
    assert (it.found, it.drawn) == (COUNT, COUNT)
    assert names(it.folder) == {entry(tmp_path).name}


def test_another_key_is_another_sequence(tmp_path: Path) -> None:
    fill(tmp_path)
    drawn = cache(tmp_path).light(OTHER, SHAPE, COUNT, lambda: lights(seed=1))
    assert same(drawn, lights(seed=1))
    assert same(cache(tmp_path).light(KEY, SHAPE, COUNT, never), lights())
    assert same(cache(tmp_path).light(OTHER, SHAPE, COUNT, never), lights(seed=1))


def test_a_reader_that_asks_for_no_more_than_there_is_has_the_entry_kept(tmp_path: Path) -> None:
    samples = cache(tmp_path).light(KEY, SHAPE, COUNT, lights)
    assert len(list(islice(samples, COUNT))) == COUNT
    assert names(tmp_path) == {entry(tmp_path).name}


def test_what_was_not_drawn_to_its_end_does_not_count(tmp_path: Path) -> None:
    samples = cache(tmp_path).light(KEY, SHAPE, COUNT, lights)
    next(samples)
    assert [name.rpartition(".")[2] for name in names(tmp_path)] == ["part"]
    samples.close()
    assert names(tmp_path) == set()


def test_a_drawing_that_fails_leaves_nothing_and_says_so_itself(tmp_path: Path) -> None:
    def lost() -> LuminanceStream:
        yield from islice(lights(), 2)
        raise RendererError("the Vulkan device is lost")

    with pytest.raises(RendererError, match="lost"):
        list(cache(tmp_path).light(KEY, SHAPE, COUNT, lost))
    assert names(tmp_path) == set()


def test_the_drawing_is_closed_when_the_reader_stops(tmp_path: Path) -> None:
    closed = []

    def drawing() -> LuminanceStream:
        try:
            yield from lights()
        finally:
            closed.append(True)

    samples = cache(tmp_path).light(KEY, SHAPE, COUNT, drawing)
    next(samples)
    samples.close()
    assert closed == [True]


def test_an_entry_cut_anywhere_is_drawn_anew(tmp_path: Path) -> None:
    fill(tmp_path)
    whole = entry(tmp_path).read_bytes()
    for size in range(len(whole)):
        entry(tmp_path).write_bytes(whole[:size])
        it = fill(tmp_path)
        assert it.found + it.drawn == COUNT
        assert it.drawn > 0
        assert entry(tmp_path).read_bytes() == whole


def test_an_entry_with_a_flip_anywhere_is_drawn_anew(tmp_path: Path) -> None:
    fill(tmp_path)
    whole = entry(tmp_path).read_bytes()
    for place in range(len(whole)):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << place % 8
        entry(tmp_path).write_bytes(damaged)
        it = fill(tmp_path)
        assert it.found + it.drawn == COUNT
        assert it.drawn > 0
        assert entry(tmp_path).read_bytes() == whole


def test_a_damaged_entry_is_removed_even_where_it_cannot_be_replaced(tmp_path: Path) -> None:
    fill(tmp_path)
    entry(tmp_path).write_bytes(b"light")
    said: list[str] = []
    fill(tmp_path, limit_bytes=1, warn=said.append)
    assert names(tmp_path) == set()


def test_what_was_used_longest_ago_goes_first(tmp_path: Path) -> None:
    keys = [letter * 64 for letter in "abcd"]
    size = 0
    for age, key in enumerate(keys[:3]):
        fill(tmp_path, key)
        os.utime(entry(tmp_path, key), (age, age))
        size = entry(tmp_path, key).stat().st_size
    fill(tmp_path, keys[0])  # used again
    fill(tmp_path, keys[3], limit_bytes=3 * size)
    assert names(tmp_path) == {entry(tmp_path, key).name for key in (keys[0], keys[2], keys[3])}
    fill(tmp_path, "e" * 64, limit_bytes=size)
    assert names(tmp_path) == {f"{'e' * 64}.light"}


def test_an_entry_beyond_the_bound_is_not_kept_and_takes_no_other_with_it(tmp_path: Path) -> None:
    fill(tmp_path)
    size = entry(tmp_path).stat().st_size
    said: list[str] = []
    it = cache(tmp_path, limit_bytes=size, warn=said.append)
    assert same(it.light(OTHER, SHAPE, 40, lambda: lights(40)), lights(40))
    assert same(it.light("c" * 64, SHAPE, 40, lambda: lights(40)), lights(40))
    assert names(tmp_path) == {entry(tmp_path).name}
    (sentence,) = said
    assert "GB that are allowed in" in sentence


def test_a_bound_below_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SimError, match="limit_bytes is -1; allowed is 0 or more"):
        LuminanceCache(tmp_path, limit_bytes=-1)


def test_an_evicted_entry_is_still_read_to_its_end(tmp_path: Path) -> None:
    fill(tmp_path)
    samples = cache(tmp_path).light(KEY, SHAPE, COUNT, never)
    first = next(samples)
    fill(tmp_path, OTHER, limit_bytes=entry(tmp_path).stat().st_size)
    assert names(tmp_path) == {entry(tmp_path, OTHER).name}
    assert same(iter([first, *samples]), lights())


def test_other_files_are_left_alone(tmp_path: Path) -> None:
    mine = {"holiday.light", "download.part", "notes.txt", f"{KEY}.txt"}
    for name in mine:
        (tmp_path / name).write_text("mine")
    fill(tmp_path, limit_bytes=1_000)
    assert names(tmp_path) == mine | {entry(tmp_path).name}


def test_a_folder_that_cannot_be_made_is_said_once_and_nothing_else_changes(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    said: list[str] = []
    it = cache(tmp_path / "file" / "folder", warn=said.append)
    for key in (KEY, OTHER):
        assert same(it.light(key, SHAPE, COUNT, lights), lights())
    (sentence,) = said
    assert str(it.folder) in sentence
    assert "Not a directory" in sentence


def test_without_a_listener_it_is_a_warning(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        assert same(LuminanceCache(tmp_path / "file").light(KEY, SHAPE, COUNT, lights), lights())
    assert len(said) == 1


@contextmanager
def no_file_beyond(size: int) -> Iterator[None]:
    """As a full disk does, writing fails half way."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)


@pytest.mark.parametrize("size", [0, 100, 20_000])
def test_a_disk_that_is_full_is_said_once_and_leaves_nothing(tmp_path: Path, size: int) -> None:
    """In the midst, and, where all is still in a buffer, at the end."""
    said: list[str] = []
    it = cache(tmp_path, warn=said.append)
    with no_file_beyond(size):
        drawn = list(it.light(KEY, (50, 70), COUNT, lambda: lights(shape=(50, 70))))
        again = list(it.light(OTHER, (50, 70), COUNT, lambda: lights(shape=(50, 70))))
    assert same(iter(drawn), lights(shape=(50, 70)))
    assert same(iter(again), lights(shape=(50, 70)))
    assert names(tmp_path) == set()
    (sentence,) = said
    assert "File too large" in sentence


def test_an_entry_that_is_a_folder_is_no_entry(tmp_path: Path) -> None:
    entry(tmp_path).mkdir()
    said: list[str] = []
    fill(tmp_path, warn=said.append)
    assert len(said) == 1
    assert names(tmp_path) == {entry(tmp_path).name}


DIES = """
import os, signal, sys
from pathlib import Path
from sim.cache.luminance_cache import LuminanceCache
from tests.sim.lights import KEY, SHAPE, lights
samples = LuminanceCache(Path(sys.argv[1])).light(KEY, SHAPE, 4, lights)
next(samples)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_a_killed_writer_left_counts_for_nothing_and_is_swept(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", DIES, str(tmp_path)], check=False)
    assert done.returncode == -signal.SIGKILL
    (left,) = names(tmp_path)
    assert left.endswith(".part")
    writing = cache(tmp_path).light(OTHER, SHAPE, COUNT, lights)
    next(writing)
    assert left not in names(tmp_path)
    fill(tmp_path)  # and does not sweep the one who still writes
    assert same(iter(list(writing)[-1:]), iter(list(lights())[-1:]))
    assert names(tmp_path) == {entry(tmp_path).name, entry(tmp_path, OTHER).name}


def _use(folder: Path, keys: list[str], limit_bytes: int, barrier: Any) -> int:
    barrier.wait()
    wrong = 0
    for turn in range(60):
        key = keys[turn % len(keys)]
        it = cache(folder, limit_bytes=limit_bytes)
        wrong += not same(it.light(key, SHAPE, 20, lambda: lights(20)), lights(20))
    return wrong


def _report(queue: Any, *arguments: Any) -> None:
    queue.put(_use(*arguments))


def test_processes_that_want_the_same_entries_all_get_the_right_light(tmp_path: Path) -> None:
    """With room for two of three, so that they also evict what the others read."""
    list(cache(tmp_path / "one").light(KEY, SHAPE, 20, lambda: lights(20)))
    limit = int(2.5 * entry(tmp_path / "one").stat().st_size)
    keys, spawn = [letter * 64 for letter in "abc"], multiprocessing.get_context("spawn")
    queue, barrier = spawn.Queue(), spawn.Barrier(3)
    arguments = queue, tmp_path / "all", keys, limit, barrier
    workers = [spawn.Process(target=_report, args=arguments) for _ in range(3)]
    for worker in workers:
        worker.start()
    assert [queue.get(timeout=120) for _ in workers] == [0, 0, 0]
    for worker in workers:
        worker.join()
    assert {name.rpartition(".")[2] for name in names(tmp_path / "all")} == {"light"}
    taken = sum(path.stat().st_size for path in (tmp_path / "all").iterdir())
    assert 0 < taken <= limit


class NoRenderer:
    def __init__(self, *_: Any) -> None:
        raise AssertionError("rendered")


@pytest.mark.parametrize("lighting", [Lighting.DAY, Lighting.NIGHT])
def test_a_crossing_from_the_cache_is_that_which_was_rendered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lighting: Lighting
) -> None:
    config = CrossingConfig(lighting=lighting, step_px=8.0, supersample=1, keyframe_px=128.0)

    def samples(cache: LuminanceCache | None) -> list[Any]:
        crossing = Crossing(config, cache=cache)
        times_us = crossing.times_us()
        return list(crossing.samples(times_us[: len(times_us) // 2]))

    rendered, kept = samples(None), samples(cache(tmp_path))
    monkeypatch.setattr(crossing_module, "FilamentRenderer", NoRenderer)
    read = samples(cache(tmp_path))
    assert len(rendered) == len(kept) == len(read) > 25
    for one, *others in zip(rendered, kept, read, strict=True):
        for other in others:
            assert (one.t_us, one.changed) == (other.t_us, other.changed)
            assert np.array_equal(one.luminance, other.luminance)
            assert np.array_equal(one.truth.target.labels, other.truth.target.labels)
            assert one.truth.bounding_box_px == other.truth.bounding_box_px
            assert one.truth.visibility == other.truth.visibility
            assert np.array_equal(one.truth.image_velocity_px_s, other.truth.image_velocity_px_s)


def test_light_is_passed_on_as_it_was_given(tmp_path: Path) -> None:
    given = list(lights())
    for light, original in zip(
        cache(tmp_path).light(KEY, SHAPE, COUNT, lambda: (x for x in given)), given, strict=True
    ):
        assert light is original
        assert isinstance(light, Light)


def test_what_goes_with_light_is_made_once_and_anew_where_it_is_damaged(tmp_path: Path) -> None:
    made: list[bytes] = []

    def make() -> bytes:
        made.append(b"picture")
        return made[-1]

    assert [cache(tmp_path).kept(KEY, make) for _ in range(2)] == [b"picture"] * 2
    assert len(made) == 1
    whole = entry(tmp_path).read_bytes()
    for damaged in (b"", whole[:-1], whole[:3], whole[:-1] + b"!"):
        entry(tmp_path).write_bytes(damaged)
        assert cache(tmp_path).kept(KEY, make) == b"picture"
        assert entry(tmp_path).read_bytes() == whole
    assert len(made) == 5


def test_what_goes_with_light_counts_in_the_bound(tmp_path: Path) -> None:
    it = cache(tmp_path, limit_bytes=1000)
    for key in (KEY, OTHER):
        assert it.kept(key, lambda: bytes(600)) == bytes(600)
    assert names(tmp_path) == {entry(tmp_path, OTHER).name}


def drawn_ahead(crossing: Crossing, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Times that are drawn ahead, of light that is a still image."""
    still = np.zeros((260, 346), np.float32), np.zeros((260, 346), np.int32)

    def draw(_: Crossing, times_us: list[int]) -> LuminanceStream:
        for t_us in times_us:
            yield Light(t_us, *still, changed=(0, 0, 346, 260))

    monkeypatch.setattr(Crossing, "times_us", lambda _: [0, 1000, 2000])
    monkeypatch.setattr(Crossing, "_rendered_luminance", draw)
    return list(crossing.render_ahead())


def test_light_is_drawn_ahead_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    crossing = Crossing(CrossingConfig(), cache=cache(tmp_path))
    assert drawn_ahead(crossing, monkeypatch) == [0, 1000, 2000]
    assert drawn_ahead(crossing, monkeypatch) == []
    assert crossing.cache is not None
    assert crossing.cache.drawn == 3


def test_what_cannot_be_kept_is_not_drawn_ahead(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    crossing = Crossing(CrossingConfig(), cache=cache(tmp_path, limit_bytes=1, warn=said.append))
    assert drawn_ahead(crossing, monkeypatch) == []
    assert len(said) == 1
    assert drawn_ahead(Crossing(CrossingConfig()), monkeypatch) == []
