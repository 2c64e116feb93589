"""Write files of every format, and read them back with flybench and with other libraries."""

from pathlib import Path

import aedat
import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from emulator import ApsFrame
from flybench.events import EVENT_DTYPE, Events
from formats import (
    ENDINGS,
    Chunk,
    FormatError,
    MissingLibraryError,
    open_events,
    open_writer,
    read_events,
    write_events,
)
from tests.formats.sample_files import SIZE, random_events, random_frames

W, H = SIZE
ALL = sorted(ENDINGS)
FAERY = np.dtype([("t", "<u8"), ("x", "<u2"), ("y", "<u2"), (("p", "on"), "?")])


def read_with_aedat(path: Path) -> Events:
    packets = [packet["events"] for packet in aedat.Decoder(path) if "events" in packet]
    decoded = np.concatenate(packets)
    events = np.zeros(decoded.size, EVENT_DTYPE)
    for column, name in zip("txyp", ("t", "x", "y", "on"), strict=True):
        events[column] = decoded[name]
    return events


def read_with_h5py(path: Path) -> Events:
    with h5py.File(path) as file:
        events = np.zeros(file["events/t"].size, EVENT_DTYPE)
        for name in "txyp":
            events[name] = file["events"][name][:]
        index = file["ms_to_idx"][:]
        assert np.array_equal(index, np.searchsorted(events["t"], np.arange(index.size) * 1000))
        assert index[-1] == events.size
        assert (file.attrs["width"], file.attrs["height"]) == SIZE
    return events


def read_with_faery(path: Path) -> Events:
    from faery.extension import evt

    with evt.Decoder(path, None, None) as decoder:
        assert (decoder.version, decoder.dimensions) == ("evt3", SIZE)
        packets = [packet["events"] for packet in decoder if "events" in packet]
    decoded = np.concatenate([np.zeros(0, FAERY), *packets])
    events = np.zeros(decoded.size, EVENT_DTYPE)
    for column, name in zip("txyp", ("t", "x", "y", "on"), strict=True):
        events[column] = decoded[name]
    return events


def read_with_loadtxt(path: Path) -> Events:
    in_seconds = path.suffix == ".txt"
    table = np.loadtxt(path, delimiter=None if in_seconds else ",", skiprows=1 if in_seconds else 2)
    events = np.zeros(len(table), EVENT_DTYPE)
    events["t"] = np.rint(table[:, 0] * (1e6 if in_seconds else 1))
    events["x"], events["y"], events["p"] = table[:, 1:].T
    return events


def read_with_numpy(path: Path) -> Events:
    with np.load(path) as arrays:
        assert (arrays["width"], arrays["height"]) == SIZE
        events = np.zeros(arrays["t"].size, EVENT_DTYPE)
        for name in "txyp":
            events[name] = arrays[name]
    return events


OTHER_READERS = {
    ".aedat4": read_with_aedat,
    ".h5": read_with_h5py,
    ".raw": read_with_faery,
    ".txt": read_with_loadtxt,
    ".csv": read_with_loadtxt,
    ".npz": read_with_numpy,
}


@pytest.mark.parametrize("ending", OTHER_READERS)
def test_another_library_reads_the_same_events(tmp_path: Path, ending: str) -> None:
    path, events = tmp_path / f"a{ending}", random_events(5000, last_us=40_000_000)
    write_events(path, np.split(events, [0, 1, 700, 4000]), width=W, height=H)
    assert np.array_equal(OTHER_READERS[ending](path), events)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_other_libraries_read_the_frames(tmp_path: Path) -> None:
    path = tmp_path / "a.aedat4"
    chunks = [
        Chunk(random_events(), tuple(random_frames()[:1])),
        Chunk(random_events(0), tuple(random_frames()[1:])),
    ]
    write_events(path, chunks, width=W, height=H)
    assert np.array_equal(read_with_aedat(path), random_events())
    decoded = [packet["frame"] for packet in aedat.Decoder(path) if "frame" in packet]
    for frame, other in zip(random_frames(), decoded, strict=True):
        assert (frame.start_us, frame.end_us) == (
            other["exposure_begin_t"],
            other["exposure_end_t"],
        )
        assert np.array_equal(frame.image, other["pixels"])
    import dv_processing

    recording = dv_processing.io.MonoCameraRecording(str(path))
    assert tuple(recording.getEventResolution()) == SIZE
    assert np.array_equal(recording.getNextFrame().image, random_frames()[0].image)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@settings(max_examples=5, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    ending=st.sampled_from(ALL),
    steps=st.lists(st.sampled_from([0, 1, 4095, 4096, 16_777_215, 50_331_648]), max_size=8),
    cuts=st.lists(st.integers(0, 8), max_size=3).map(sorted),
)
def test_events_survive_a_round_trip(
    tmp_path: Path, ending: str, steps: list[int], cuts: list[int]
) -> None:
    path, events = tmp_path / f"a{ending}", random_events(len(steps))
    events["t"] = np.cumsum(steps)
    write_events(path, np.split(events, cuts), width=W, height=H)
    assert np.array_equal(read_events(path, size=SIZE), events)


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    times=st.lists(st.integers(0, 20_000), max_size=200).map(sorted),
    cuts=st.lists(st.integers(0, 200), max_size=5).map(sorted),
)
def test_the_index_of_dsec_is_right(tmp_path: Path, times: list[int], cuts: list[int]) -> None:
    path, events = tmp_path / "a.h5", random_events(len(times))
    events["t"] = times
    write_events(path, np.split(events, cuts), width=W, height=H)
    assert np.array_equal(read_with_h5py(path), events)  # compares the index too


def write_half_and_fail(path: Path) -> None:
    with open_writer(path, width=W, height=H) as writer:
        writer.write(random_events())
        if writer.takes_frames:
            writer.write_frame(random_frames()[0])
        raise ZeroDivisionError


@pytest.mark.parametrize("ending", ALL)
def test_a_failed_write_keeps_the_old_file(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"a{ending}"
    path.write_bytes(b"before")
    with pytest.raises(ZeroDivisionError):
        write_half_and_fail(path)
    assert path.read_bytes() == b"before"
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@settings(max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    steps=st.lists(
        st.sampled_from([0, 1, 4095, 4096, 65_535, 65_536, 8_388_608, 16_777_215, 16_777_216])
        | st.integers(0, 60_000_000),
        max_size=20,
    ),
    cuts=st.lists(st.integers(0, 20), max_size=3).map(sorted),
)
def test_evt3_keeps_every_time(tmp_path: Path, steps: list[int], cuts: list[int]) -> None:
    path, events = tmp_path / "a.raw", random_events(len(steps))
    events["t"] = np.cumsum(steps)
    write_events(path, np.split(events, cuts), width=W, height=H)
    assert np.array_equal(read_with_faery(path), events)


@pytest.mark.parametrize("ending", ALL)
def test_a_recording_without_events_is_written(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"a{ending}"
    write_events(path, [], width=W, height=H)
    with open_events(path, size=SIZE) as file:
        assert [chunk.events.size for chunk in file] == []
        assert file.statistics.rate_hz == file.statistics.on_share == 0


def test_invalid_output_is_refused(tmp_path: Path) -> None:
    for name, size, message in (
        ("a.mp4", SIZE, "ends in .mp4. Allowed is one of .aedat4"),
        ("nowhere/a.txt", SIZE, "does not exist. Create it"),
        ("a.raw", (2049, 5), "1 to 2048"),
        ("a.h5", (0, 5), "0x5"),
    ):
        with pytest.raises(FormatError, match=message):
            open_writer(tmp_path / name, width=size[0], height=size[1])
    with pytest.raises(FormatError, match="is a folder"):
        open_writer(tmp_path, width=W, height=H, format="text")
    with pytest.raises(FormatError, match="Allowed is one of aedat4"):
        open_writer(tmp_path / "a", width=W, height=H, format="bag")
    with open_writer(tmp_path / "a.h5", width=W, height=H) as writer:
        writer.write(random_events())
        with pytest.raises(FormatError, match="comes after"):
            writer.write(random_events())
        with pytest.raises(FormatError, match="a format without frames"):
            writer.write_frame(random_frames()[0])
        bad = random_events(1)
        bad["x"] = 346
        with pytest.raises(FormatError, match="x = 346"):
            writer.write(bad)
        late = random_events(1)
        late["t"] = 10**11
        with pytest.raises(FormatError, match="Subtract the time"):
            writer.write(late)
    with open_writer(tmp_path / "a.aedat4", width=W, height=H) as writer:
        small = ApsFrame(start_us=0, end_us=1, image=np.zeros((4, 5), np.uint16))
        with pytest.raises(FormatError, match="a frame has 5x4"):
            writer.write_frame(small)


def write_to_a_full_disk(path: Path) -> None:
    with (
        open_writer(path, width=W, height=H) as writer,
        Path("/dev/full").open("wb", buffering=0) as full,
    ):
        spools = writer._spools  # type: ignore[attr-defined]
        spools["t"].close()
        spools["t"] = full
        writer.write(random_events())


def test_a_write_protected_folder_and_a_full_disk_are_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(FormatError, match="write-protected"):
        open_writer(tmp_path / "a.txt", width=W, height=H)
    monkeypatch.undo()
    with pytest.raises(FormatError, match="is full"):
        write_to_a_full_disk(tmp_path / "a.npz")
    assert list(tmp_path.iterdir()) == []


def test_a_missing_library_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "faery", None)
    with pytest.raises(MissingLibraryError, match=r"faery.*pip install"):
        open_writer(tmp_path / "a.aedat4", width=W, height=H)


@pytest.mark.parametrize("ending", ALL)
def test_the_caller_may_reuse_its_array_after_writing(tmp_path: Path, ending: str) -> None:
    events = random_events(100)
    expected, path = events.copy(), tmp_path / f"a{ending}"
    with open_writer(path, width=W, height=H) as writer:
        writer.write(events)
        events["t"] = 0
    assert np.array_equal(read_events(path), expected)
