"""The luminance cache: rendered once, limited in size, shared, and safe against damaged files."""

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
from sim.cache.luminance_file import LuminanceSample
from sim.errors import RendererError
from tests.sim.luminance_samples import KEY, OTHER_KEY, SHAPE, equal, samples

COUNT = 4


def fail_on_warning(message: str) -> None:
    raise AssertionError(message)


def cache(folder: Path, **options: Any) -> LuminanceCache:
    return LuminanceCache(folder, **({"warn": fail_on_warning} | options))


def must_not_render(_start: int) -> LuminanceStream:
    raise AssertionError("rendered")
    yield


def entry(folder: Path, key: str = KEY) -> Path:
    return folder / f"{key}.light"


def fill(folder: Path, key: str = KEY, **options: Any) -> LuminanceCache:
    filled = cache(folder, **options)
    assert equal(filled.samples(key, SHAPE, COUNT, samples), samples())
    return filled


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} - {LOCK}


def test_a_sequence_is_rendered_once(tmp_path: Path) -> None:
    filled = fill(tmp_path / "made" / "when needed")
    assert (filled.read, filled.rendered) == (0, COUNT)
    assert equal(filled.samples(KEY, SHAPE, COUNT, must_not_render), samples())
    assert (filled.read, filled.rendered) == (COUNT, COUNT)
    assert names(filled.folder) == {entry(tmp_path).name}


def test_another_key_is_another_sequence(tmp_path: Path) -> None:
    fill(tmp_path)
    rendered = cache(tmp_path).samples(
        OTHER_KEY, SHAPE, COUNT, lambda start: samples(start, seed=1)
    )
    assert equal(rendered, samples(seed=1))
    for key, seed in ((KEY, 0), (OTHER_KEY, 1)):
        stored = cache(tmp_path).samples(key, SHAPE, COUNT, must_not_render)
        assert equal(stored, samples(seed=seed))


def test_an_entry_is_stored_once_the_last_sample_is_taken(tmp_path: Path) -> None:
    stream = cache(tmp_path).samples(KEY, SHAPE, COUNT, samples)
    assert len(list(islice(stream, COUNT))) == COUNT
    assert names(tmp_path) == {entry(tmp_path).name}


def parts(folder: Path) -> list[str]:
    return [name.rpartition(".")[2] for name in names(folder)]


@pytest.mark.parametrize("taken", range(COUNT))
def test_a_sequence_is_continued_where_its_reader_stopped(tmp_path: Path, taken: int) -> None:
    stream = cache(tmp_path).samples(KEY, SHAPE, COUNT, samples)
    assert equal(islice(stream, taken), islice(samples(), taken))
    stream.close()
    assert parts(tmp_path) == ["part"] * (taken > 0)
    filled = fill(tmp_path)
    assert (filled.read, filled.rendered) == (taken, COUNT - taken)
    assert parts(tmp_path) == ["light"]
    assert equal(cache(tmp_path).samples(KEY, SHAPE, COUNT, must_not_render), samples())


def test_a_reader_that_stops_at_once_loses_nothing(tmp_path: Path) -> None:
    for taken in (3, 1, 0, 2):
        stream = cache(tmp_path).samples(KEY, SHAPE, COUNT, samples)
        list(islice(stream, taken))
        stream.close()
    filled = fill(tmp_path)
    assert (filled.read, filled.rendered) == (3, COUNT - 3)


def test_an_error_while_rendering_is_passed_on_and_loses_nothing(tmp_path: Path) -> None:
    def render(_start: int) -> LuminanceStream:
        yield from islice(samples(), 2)
        raise RendererError("the Vulkan device is lost")

    with pytest.raises(RendererError, match="lost"):
        list(cache(tmp_path).samples(KEY, SHAPE, COUNT, render))
    filled = fill(tmp_path)
    assert (filled.read, filled.rendered) == (2, COUNT - 2)


def test_a_partial_entry_truncated_anywhere_is_continued(tmp_path: Path) -> None:
    fill(tmp_path)
    whole = entry(tmp_path).read_bytes()
    for size in range(1, len(whole) + 1):
        entry(tmp_path).unlink()
        (tmp_path / f"{KEY}.x.part").write_bytes(whole[:size])
        filled = fill(tmp_path)
        assert filled.read + filled.rendered == COUNT
        assert filled.rendered > 0
        assert entry(tmp_path).read_bytes() == whole


def test_partial_entries_count_towards_the_limit(tmp_path: Path) -> None:
    fill(tmp_path)
    size = entry(tmp_path).stat().st_size
    (tmp_path / f"{OTHER_KEY}.x.part").write_bytes(bytes(size))
    os.utime(tmp_path / f"{OTHER_KEY}.x.part", (1, 1))
    fill(tmp_path, "c" * 64, limit_bytes=2 * size)
    assert names(tmp_path) == {entry(tmp_path).name, entry(tmp_path, "c" * 64).name}


def test_rendering_is_closed_when_the_reader_stops(tmp_path: Path) -> None:
    closed = []

    def render(_start: int) -> LuminanceStream:
        try:
            yield from samples()
        finally:
            closed.append(True)

    stream = cache(tmp_path).samples(KEY, SHAPE, COUNT, render)
    next(stream)
    stream.close()
    assert closed == [True]


def test_an_entry_truncated_anywhere_is_rendered_again(tmp_path: Path) -> None:
    fill(tmp_path)
    whole = entry(tmp_path).read_bytes()
    for size in range(len(whole)):
        entry(tmp_path).write_bytes(whole[:size])
        filled = fill(tmp_path)
        assert filled.read + filled.rendered == COUNT
        assert filled.rendered > 0
        assert entry(tmp_path).read_bytes() == whole


def test_an_entry_with_a_flipped_bit_anywhere_is_rendered_again(tmp_path: Path) -> None:
    fill(tmp_path)
    whole = entry(tmp_path).read_bytes()
    for place in range(len(whole)):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << place % 8
        entry(tmp_path).write_bytes(damaged)
        filled = fill(tmp_path)
        assert filled.read + filled.rendered == COUNT
        assert filled.rendered > 0
        assert entry(tmp_path).read_bytes() == whole


def test_a_damaged_entry_is_deleted_even_if_it_cannot_be_replaced(tmp_path: Path) -> None:
    fill(tmp_path)
    entry(tmp_path).write_bytes(b"light")
    warned: list[str] = []
    fill(tmp_path, limit_bytes=1, warn=warned.append)
    assert names(tmp_path) == set()


def test_the_entries_used_longest_ago_are_deleted_first(tmp_path: Path) -> None:
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


def test_an_entry_above_the_limit_is_not_stored_and_evicts_nothing(tmp_path: Path) -> None:
    fill(tmp_path)
    size = entry(tmp_path).stat().st_size
    warned: list[str] = []
    limited = cache(tmp_path, limit_bytes=size, warn=warned.append)
    for key in (OTHER_KEY, "c" * 64):
        assert equal(
            limited.samples(key, SHAPE, 40, lambda start: samples(start, 40)), samples(count=40)
        )
    assert names(tmp_path) == {entry(tmp_path).name}
    (message,) = warned
    assert "takes more than the" in message


def test_a_negative_limit_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SimError, match=r"limit_bytes is -1\. Allowed is 0 or more"):
        LuminanceCache(tmp_path, limit_bytes=-1)


def test_an_entry_deleted_while_it_is_read_is_read_to_its_end(tmp_path: Path) -> None:
    fill(tmp_path)
    stream = cache(tmp_path).samples(KEY, SHAPE, COUNT, must_not_render)
    first = next(stream)
    fill(tmp_path, OTHER_KEY, limit_bytes=entry(tmp_path).stat().st_size)
    assert names(tmp_path) == {entry(tmp_path, OTHER_KEY).name}
    assert equal(iter([first, *stream]), samples())


def test_other_files_are_left_alone(tmp_path: Path) -> None:
    mine = {"holiday.light", "download.part", "notes.txt", f"{KEY}.txt"}
    for name in mine:
        (tmp_path / name).write_text("mine")
    fill(tmp_path, limit_bytes=1_000)
    assert names(tmp_path) == mine | {entry(tmp_path).name}


def test_a_folder_that_cannot_be_made_gives_one_warning_and_the_samples(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    warned: list[str] = []
    broken = cache(tmp_path / "file" / "folder", warn=warned.append)
    for key in (KEY, OTHER_KEY):
        assert equal(broken.samples(key, SHAPE, COUNT, samples), samples())
    (message,) = warned
    assert str(broken.folder) in message
    assert "Not a directory" in message


def test_by_default_the_message_is_a_python_warning(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        stream = LuminanceCache(tmp_path / "file").samples(KEY, SHAPE, COUNT, samples)
        assert equal(stream, samples())
    assert len(warned) == 1


@contextmanager
def no_file_beyond(size: int) -> Iterator[None]:
    """Make writing fail half way, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)


@pytest.mark.parametrize("size", [0, 100, 20_000])
def test_a_full_disk_gives_one_warning_and_leaves_no_file(tmp_path: Path, size: int) -> None:
    """Writing fails half way or, if everything is still in a buffer, at the end."""
    shape = (50, 70)
    warned: list[str] = []
    full = cache(tmp_path, warn=warned.append)
    with no_file_beyond(size):
        found = [
            list(full.samples(key, shape, COUNT, lambda start: samples(start, shape=shape)))
            for key in (KEY, OTHER_KEY)
        ]
    for stream in found:
        assert equal(iter(stream), samples(shape=shape))
    assert names(tmp_path) == set()
    (message,) = warned
    assert "File too large" in message


def test_a_folder_with_the_name_of_an_entry_gives_one_warning(tmp_path: Path) -> None:
    entry(tmp_path).mkdir()
    warned: list[str] = []
    fill(tmp_path, warn=warned.append)
    assert len(warned) == 1
    assert names(tmp_path) == {entry(tmp_path).name}


KILLED_WRITER = """
import os, signal, sys
from pathlib import Path
from sim.cache.luminance_cache import LuminanceCache
from tests.sim.luminance_samples import KEY, SHAPE, samples
large = (80, 80)  # records above the size of a buffer reach the disk at once
stream = LuminanceCache(Path(sys.argv[1])).samples(
    KEY, large, 4, lambda start: samples(start, shape=large)
)
next(stream)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_the_file_of_a_killed_writer_is_continued(tmp_path: Path) -> None:
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", KILLED_WRITER, str(tmp_path)], check=False)
        assert done.returncode == -signal.SIGKILL
        assert parts(tmp_path) == ["part"]
    shape, after = (80, 80), cache(tmp_path)
    stream = after.samples(KEY, shape, COUNT, lambda start: samples(start, shape=shape))
    assert equal(stream, samples(shape=shape))
    assert (after.read, after.rendered) == (1, COUNT - 1)
    assert names(tmp_path) == {entry(tmp_path).name}


def test_the_file_of_a_living_writer_is_left_alone(tmp_path: Path) -> None:
    writing = cache(tmp_path).samples(KEY, SHAPE, COUNT, samples)
    first = next(writing)
    filled = fill(tmp_path)
    assert filled.read == 0
    assert equal(iter([first, *writing]), samples())
    assert names(tmp_path) == {entry(tmp_path).name}


def _count_wrong(folder: Path, keys: list[str], limit_bytes: int, barrier: Any) -> int:
    """Read or render entries many times; return how often the samples were wrong."""
    barrier.wait()
    wrong = 0
    for turn in range(60):
        key = keys[turn % len(keys)]
        shared = cache(folder, limit_bytes=limit_bytes)
        stream = shared.samples(key, SHAPE, 20, lambda start: samples(start, 20))
        wrong += not equal(stream, samples(count=20))
    return wrong


def _report(queue: Any, *arguments: Any) -> None:
    queue.put(_count_wrong(*arguments))


def test_processes_that_share_a_folder_all_get_the_right_samples(tmp_path: Path) -> None:
    """There is room for two of three entries, so that processes delete what others read."""
    list(cache(tmp_path / "one").samples(KEY, SHAPE, 20, lambda start: samples(start, 20)))
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
def test_a_crossing_from_the_cache_equals_the_rendered_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lighting: Lighting
) -> None:
    config = CrossingConfig(lighting=lighting, step_px=8.0, supersample=1, keyframe_px=64.0)

    def crossing_samples(cache: LuminanceCache | None) -> list[Any]:
        crossing = Crossing(config, cache=cache)
        times_us = crossing.times_us()
        return list(crossing.samples(times_us[: len(times_us) // 2]))

    rendered, stored = crossing_samples(None), crossing_samples(cache(tmp_path))
    monkeypatch.setattr(crossing_module, "FilamentRenderer", NoRenderer)
    read = crossing_samples(cache(tmp_path))
    assert len(rendered) == len(stored) == len(read) > 25
    for one, *others in zip(rendered, stored, read, strict=True):
        for other in others:
            assert (one.t_us, one.changed) == (other.t_us, other.changed)
            assert np.array_equal(one.luminance, other.luminance)
            assert np.array_equal(one.truth.target.labels, other.truth.target.labels)
            assert one.truth.bounding_box_px == other.truth.bounding_box_px
            assert one.truth.visibility == other.truth.visibility
            assert np.array_equal(one.truth.image_velocity_px_s, other.truth.image_velocity_px_s)


@pytest.mark.parametrize("lighting", [Lighting.DAY, Lighting.NIGHT])
def test_a_crossing_that_is_continued_equals_the_whole_one(
    tmp_path: Path, lighting: Lighting
) -> None:
    config = CrossingConfig(lighting=lighting, step_px=8.0, supersample=1, keyframe_px=64.0)
    crossing = Crossing(config, cache=cache(tmp_path))
    times_us = crossing.times_us()[::12]
    for taken in (1, len(times_us) // 2):
        stream = crossing.samples(times_us)
        list(islice(stream, taken))
        stream.close()  # type: ignore[attr-defined]
    continued = list(crossing.samples(times_us))
    assert crossing.cache is not None
    assert crossing.cache.rendered == len(times_us) == len(continued)
    for one, other in zip(Crossing(config).samples(times_us), continued, strict=True):
        assert (one.t_us, one.changed) == (other.t_us, other.changed)
        assert np.array_equal(one.luminance, other.luminance)
        assert np.array_equal(one.truth.target.labels, other.truth.target.labels)


def test_rendered_samples_are_passed_on_unchanged(tmp_path: Path) -> None:
    rendered = list(samples())
    stream = cache(tmp_path).samples(KEY, SHAPE, COUNT, lambda _start: (x for x in rendered))
    for sample, original in zip(stream, rendered, strict=True):
        assert sample is original
        assert isinstance(sample, LuminanceSample)


def test_accompanying_data_are_made_once_and_again_if_damaged(tmp_path: Path) -> None:
    made: list[bytes] = []

    def make() -> bytes:
        made.append(b"picture")
        return made[-1]

    assert [cache(tmp_path).get_or_make(KEY, make) for _ in range(2)] == [b"picture"] * 2
    assert len(made) == 1
    whole = entry(tmp_path).read_bytes()
    for damaged in (b"", whole[:-1], whole[:3], whole[:-1] + b"!"):
        entry(tmp_path).write_bytes(damaged)
        assert cache(tmp_path).get_or_make(KEY, make) == b"picture"
        assert entry(tmp_path).read_bytes() == whole
    assert len(made) == 5


def test_accompanying_data_count_towards_the_limit(tmp_path: Path) -> None:
    limited = cache(tmp_path, limit_bytes=1000)
    for key in (KEY, OTHER_KEY):
        assert limited.get_or_make(key, lambda: bytes(600)) == bytes(600)
    assert names(tmp_path) == {entry(tmp_path, OTHER_KEY).name}


def rendered_ahead(crossing: Crossing, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return the times that are rendered ahead, for a constant image instead of a scene."""
    black = np.zeros((260, 346), np.float32), np.zeros((260, 346), np.int32)

    def render(_: Crossing, times_us: list[int], start: int) -> LuminanceStream:
        for t_us in times_us[start:]:
            yield LuminanceSample(t_us, *black, changed=(0, 0, 346, 260))

    monkeypatch.setattr(Crossing, "times_us", lambda _: [0, 1000, 2000])
    monkeypatch.setattr(Crossing, "_rendered_luminance", render)
    return list(crossing.render_ahead())


def test_a_sequence_is_rendered_ahead_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    crossing = Crossing(CrossingConfig(), cache=cache(tmp_path))
    assert rendered_ahead(crossing, monkeypatch) == [0, 1000, 2000]
    assert rendered_ahead(crossing, monkeypatch) == []
    assert crossing.cache is not None
    assert crossing.cache.rendered == 3


def test_a_sequence_that_cannot_be_stored_is_not_rendered_ahead(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    warned: list[str] = []
    limited = cache(tmp_path, limit_bytes=1, warn=warned.append)
    assert rendered_ahead(Crossing(CrossingConfig(), cache=limited), monkeypatch) == []
    assert len(warned) == 1
    assert rendered_ahead(Crossing(CrossingConfig()), monkeypatch) == []


def test_a_fifo_does_not_block(tmp_path: Path) -> None:
    for path in (entry(tmp_path), entry(tmp_path, OTHER_KEY), tmp_path / f"{KEY}.x.part"):
        os.mkfifo(path)
    fill(tmp_path)
    assert entry(tmp_path).is_file()
    assert cache(tmp_path).get_or_make(OTHER_KEY, lambda: b"made") == b"made"
