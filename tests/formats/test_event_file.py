"""Read files of every format."""

import gzip
import os
import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from emulator import ApsFrame
from flybench.events import EVENT_DTYPE, check_events
from flybench.memory import MemoryBudgetError
from formats import FormatError, open_events, open_writer, read_events, write_events
from formats.columns import PARSED_DTYPE
from tests.formats.sample_files import (
    FILE_MAKERS,
    SIZE,
    WITHOUT_SIZE,
    make_file,
    make_hdf5,
    random_events,
    random_frames,
)


def test_the_parser_and_flybench_have_the_same_event_dtype() -> None:
    assert PARSED_DTYPE == EVENT_DTYPE


@pytest.mark.parametrize("name", FILE_MAKERS)
def test_every_format_is_recognised_under_any_ending(tmp_path: Path, name: str) -> None:
    events = random_events(3000)
    path = make_file(tmp_path, name, events).rename(tmp_path / "recording.xyz")
    size = SIZE if name in WITHOUT_SIZE else None
    with open_events(path, size=size) as file:
        chunks = list(file)
        statistics = file.statistics
    assert (file.width, file.height) == SIZE
    assert file.size_source == ("the option" if size else "the file")
    assert re.match(r"(µs|s), (as|because|from) \w+", file.header_fields["time unit"])
    assert file.warnings == ()
    got = np.concatenate([chunk.events for chunk in chunks])
    assert np.array_equal(got, events)
    check_events(got, width=346, height=260)
    assert (statistics.events, statistics.on) == (events.size, int(events["p"].sum()))
    assert (statistics.first_us, statistics.last_us) == (events["t"][0], events["t"][-1])
    assert statistics.rate_hz == pytest.approx(events.size / np.ptp(events["t"]) * 1e6)
    assert (statistics.x_min, statistics.x_max) == (events["x"].min(), events["x"].max())
    frames = [frame for chunk in chunks for frame in chunk.frames]
    assert len(frames) == statistics.frames == (3 if name == "a.aedat4" else 0)
    assert file.has_frames == bool(frames)
    for frame, written in zip(frames, random_frames(), strict=False):
        assert (frame.start_us, frame.end_us) == (written.start_us, written.end_us)
        assert np.array_equal(frame.image, written.image)


def test_a_frame_comes_with_the_events_that_reach_its_end(tmp_path: Path) -> None:
    path = make_file(tmp_path, "a.aedat4", random_events(100_000, last_us=90_000))
    with open_events(path) as file:
        reached = -1
        for chunk in file:
            reached = max(reached, int(chunk.events["t"][-1]) if chunk.events.size else reached)
            assert all(frame.end_us <= reached for frame in chunk.frames)


@pytest.mark.parametrize("sort_within_us", [0, 1_500_000])
@pytest.mark.parametrize("rate_hz", [200, 20_000])
def test_frames_never_overtake_events(tmp_path: Path, rate_hz: int, sort_within_us: int) -> None:
    events = random_events(2 * rate_hz, last_us=2_000_000)
    events["x"], events["y"] = events["x"] % 16, events["y"] % 12
    image = np.zeros((12, 16), np.uint16)
    with open_writer(tmp_path / "a.aedat4", width=16, height=12) as writer:
        for k, part in enumerate(np.split(events, np.arange(1, 100) * rate_hz // 50)):
            writer.write(part)
            writer.write_frame(ApsFrame(20_000 * k, 20_000 * k + 5000, image))
    ends_us, frame_us = [], -1
    with open_events(tmp_path / "a.aedat4", sort_within_us=sort_within_us) as file:
        chunks = list(file)
    for chunk in chunks:
        assert not chunk.events.size or chunk.events["t"][0] >= frame_us
        ends_us += [frame.end_us for frame in chunk.frames]
        frame_us = max([frame_us, *ends_us])
    assert ends_us == [20_000 * k + 5000 for k in range(100)]
    assert np.array_equal(np.concatenate([chunk.events for chunk in chunks]), events)


E = random_events(200)
SECONDS = E["t"] / 1e6
METAVISION = np.dtype([("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")])


@pytest.mark.parametrize(
    ("data_sets", "location"),
    [
        ({f"events__{name}": E[name] for name in "txyp"}, "events"),
        ({"events__ts": SECONDS, "events__ps": E["p"] * 2 - 1, "events__xs": E["x"],
          "events__ys": E["y"]}, "events"),
        ({f"prophesee__left__{name}": E[name] for name in "txyp"}
         | {f"prophesee__right__{name}": E[name][:3] for name in "txyp"}
         | {"prophesee__left__calib__resolution": [346, 260]}, "prophesee/left"),
        ({"davis__left__events": np.stack([E["x"], E["y"], SECONDS + 1.5e9, E["p"] * 2.0 - 1], 1),
          "davis__right__events": np.zeros((3, 4))}, "davis/left/events"),
        ({"CD__events": E[["x", "y", "p", "t"]].astype(METAVISION)}, "CD/events"),
    ],
    ids=["DSEC", "e2vid", "M3ED", "MVSEC", "Metavision"],
)  # fmt: skip
def test_hdf5_of_the_common_data_sets(
    tmp_path: Path, data_sets: dict[str, object], location: str
) -> None:
    path = make_hdf5(tmp_path / "a.h5", **data_sets)
    with open_events(path) as file:
        assert (file.width, file.height) == SIZE  # stated, or inferred from the events
        assert file.header_fields["events in"] == location
        got = np.concatenate([chunk.events for chunk in file])
    if location.startswith("davis"):  # wall-clock time as floating-point numbers
        assert file.origin_us == 1_500_000_000_000_000 + E["t"][0]
        got["t"] += E["t"][0]
    assert np.array_equal(got, E)


def test_a_missing_hdf5_filter_is_named(tmp_path: Path) -> None:
    space = h5py.h5s.create_simple((10,), (10,))
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_chunk((10,))
    plist.set_filter(0x8ECF, h5py.h5z.FLAG_OPTIONAL)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        kind = h5py.h5t.py_create(METAVISION)
        h5py.h5d.create(file.create_group("CD").id, b"events", kind, space, plist)
    with pytest.raises(FormatError, match=r"ECF.*HDF5_PLUGIN_PATH"):
        open_events(tmp_path / "a.h5")


def test_blosc_compressed_hdf5_is_read(tmp_path: Path) -> None:
    import hdf5plugin

    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name in "txyp":
            file.create_dataset(
                f"events/{name}", data=E[name], chunks=(64,), compression=hdf5plugin.Blosc()
            )
    assert np.array_equal(read_events(tmp_path / "a.h5", size=SIZE), E)


@pytest.mark.parametrize(
    ("text", "times"),
    [
        ("0.000003 10 20 1\n0.000007 11 21 0\n1.5 12 20 1\n", (3, 7, 1_500_000)),
        ("346 260\n3 10 20 1\n7 11 21 0\n1500000 12 20 1\n", (3, 7, 1_500_000)),
        ("10,20,1,3\n11,21,0,7\n12,20,1,1500000\n", (3, 7, 1_500_000)),
        ("x;y;polarity;t_ms\n10;20;1;3\n11;21;-1;7\n12;20;1;15\n", (3000, 7000, 15000)),
        ("# t x y p\n\n3\t10\t20\t1\r\n7\t 11 21 0\r\n\r\n9 12 20 1", (3, 7, 9)),
        ("\ufefftime (µs),x,y,p\n3,10,20,1\n7,11,21,0\n9,12,20,1\n", (3, 7, 9)),
        ('"timestamp [ns]","x","y","on"\n3000,10,20,1\n7000,11,21,0\n9000,12,20,1\n', (3, 7, 9)),
    ],
)
def test_variants_of_text_are_read(tmp_path: Path, text: str, times: tuple[int, ...]) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(text.encode())
    got = read_events(path, size=SIZE)
    assert got["t"].tolist() == list(times)
    assert got["x"].tolist() == [10, 11, 12]
    assert got["y"].tolist() == [20, 21, 20]
    assert got["p"].tolist() == [True, False, True]


def test_options_override_what_the_file_states(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("10 20 1 3\n11 21 0 7\n")
    assert read_events(path, size=(40, 30), format="text", time_unit="ms")["t"].tolist() == [
        3000,
        7000,
    ]


def test_dvs128_addresses_are_flipped_as_in_jaer(tmp_path: Path) -> None:
    path = tmp_path / "a.aedat"
    address = (100 << 8) | (3 << 1) | 0
    records = np.array([(address, 5), (address | 1, 2**32 - 1), (address, 4)], ">u4,>u4")
    path.write_bytes(b"#!AER-DAT2.0\r\n# AEChip: ch.unizh.ini.DVS128\r\n" + records.tobytes())
    with open_events(path) as file:
        assert (file.width, file.height) == (128, 128)
        got = np.concatenate([chunk.events for chunk in file])
    assert got["x"].tolist() == [124] * 3
    assert got["y"].tolist() == [27] * 3
    assert got["p"].tolist() == [True, False, True]
    assert got["t"].tolist() == [5, 2**32 - 1, 2**32 + 4]  # its 32-bit clock overflowed


def test_evt21_with_swapped_halves_is_read(tmp_path: Path) -> None:
    path = make_file(tmp_path, "evt21.raw", E)
    header, data = path.read_bytes().split(b"% end\n")
    swapped = np.frombuffer(data, "<u4").reshape(-1, 2)[:, ::-1].tobytes()
    path.write_bytes(header + b"% end\n" + swapped)
    assert np.array_equal(read_events(path), E)


def test_a_file_can_be_read_only_once(tmp_path: Path) -> None:
    with open_events(make_file(tmp_path, "a.txt", E)) as file:
        assert sum(chunk.events.size for chunk in file) == E.size
        with pytest.raises(FormatError, match="Open it again"):
            next(iter(file))


def test_memory_does_not_grow_with_the_length_of_the_file(tmp_path: Path) -> None:
    path = make_file(tmp_path, "a.npy", np.zeros(5_000_000, EVENT_DTYPE))
    with open_events(path, size=SIZE) as file:
        parser = file._reader._process.pid
        peak_kb = longest = 0
        for chunk in file:
            status = Path(f"/proc/{parser}/status")
            text = status.read_text() if status.exists() else ""
            peak_kb = max(
                [peak_kb, *(int(line.split()[1]) for line in text.splitlines() if "VmRSS" in line)]
            )
            longest = max(longest, chunk.events.size)
        assert file.statistics.events == 5_000_000
    assert longest <= 1 << 18
    assert peak_kb < 150_000  # the file has 65 MB, an idle parser process about 60 MB


def save_array(path: Path, array: np.ndarray) -> None:
    with path.open("wb") as file:
        np.save(file, array)


@pytest.mark.parametrize(
    ("create", "message"),
    [
        (lambda _: None, "does not exist"),
        (lambda p: p.mkdir(), "is a folder"),
        (lambda p: p.touch(), "is empty"),
        (lambda p: os.mkfifo(p), "not a regular file"),
        (lambda p: p.write_bytes(bytes(range(200, 256)) * 9), "none of the formats"),
        (lambda p: p.write_bytes(gzip.compress(b"3 1 1 1")), "gunzip"),
        (lambda p: p.write_bytes(b"\0\0\0\x20ftypisom"), r"video \(MP4 or MOV\).*emulate"),
        (lambda p: p.write_bytes(b"RIFF\x01\0\0\0AVI LIST"), r"video \(AVI\).*emulate"),
        (lambda p: p.write_bytes(b"\x89PNG\r\n"), r"picture \(PNG\).*emulate"),
        (lambda p: (p.mkdir(), (p / "1.png").touch()), "folder of pictures.*emulate"),
        (lambda p: save_array(p, np.zeros((3, 5, 6), np.uint8)), "For pictures, use .* emulate"),
        (lambda p: p.write_bytes(b"#!AER-DAT1.0\r\n"), "Convert it"),
        (lambda p: p.write_text("no events here"), "no line of numbers"),
        (lambda p: p.write_text("1 2 3\n4 5 6\n"), "3 columns"),
        (lambda p: p.write_text("t,x,y\n1,2,3,4\n"), "name every column"),
        (lambda p: p.write_text("t,x,y,p\n"), "contains no events"),
        (lambda p: p.write_text("5001 2 3 1\n5002 2 x 1\n"), "line at byte 11 is '5002 2 x 1'"),
        (lambda p: p.write_bytes(b"% evt 3.0\n% end\n\0\x80"), "Give the size with --size"),
        (lambda p: p.write_text("5001 2 3 1\n2 2 3"), "may be truncated"),
        (lambda p: p.write_text("5001 2 3 1\n5002 2 3 1\n5001 2 3 1\n"), "event 2 has the time 50"),
        (lambda p: p.write_text("9 9\n5001 2 3 1\n5002 10 3 1\n"), "x = 10.0. Allowed is 0 to 8"),
        (lambda p: p.write_text("5001 2 3 1\n5002 2 3 7\n"), "p = 7.0"),
        (lambda p: p.write_text("0.1 2.5 3 1\n0.2 2 3 1\n"), "Allowed is a whole number"),
        (lambda p: p.write_text("nan 2 3 1\n2 2 3 1\n"), "nan 2 3 1"),
        (lambda p: p.write_text("99999999999999999999999999 2 3 1\n"), "not a finite number of ns"),
        (lambda p: save_array(p, np.zeros((3, 5))), "four columns"),
        (lambda p: save_array(p, np.array([None])), "Python objects"),
        (lambda p: make_hdf5(p, images=np.zeros(3)), "contains no events"),
        (lambda p: make_hdf5(p, t=[1, 2], x=[1, 2], y=[1, 2], p=[1]), "equal length"),
    ],
)  # fmt: skip
def test_unreadable_files_raise_a_one_line_error(
    tmp_path: Path, create: object, message: str
) -> None:
    path = tmp_path / "bad"
    create(path)  # type: ignore[operator]
    with pytest.raises(FormatError, match=message) as caught:
        read_events(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "advice"), [("a.xyz", "software that wrote it"), ("a.raw", "--format evt2, evt21")]
)
def test_only_what_may_be_raw_gets_advice_about_raw(tmp_path: Path, name: str, advice: str) -> None:
    (tmp_path / name).write_bytes(bytes(range(200, 256)) * 9)
    with pytest.raises(FormatError, match=advice) as caught:
        read_events(tmp_path / name)
    assert ("RAW file without" in str(caught.value)) == (name == "a.raw")


@pytest.mark.parametrize(
    ("line", "date"),
    [
        ("# Creation date: Mon Feb 10 10:57:27 AEDT 2020", "Mon Feb 10 10:57:27 AEDT 2020"),
        ("# Creation time: 09:34AM March 03 2022", "09:34AM March 03 2022"),
        ("# created Thu Jul 05 10:57:31 CEST 2012", "Thu Jul 05 10:57:31 CEST 2012"),
        ("# This is a raw AE data file created by saveaerdat.m, version 2", None),
    ],
)
def test_the_date_of_an_aedat2_file_is_shown(tmp_path: Path, line: str, date: str | None) -> None:
    path = make_file(tmp_path, "davis.aedat", E)
    first, rest = path.read_bytes().split(b"\n", 1)
    more = f"\n{line}\r\n# Creation time: System.currentTimeMillis() 1581292647203\r\n".encode()
    path.write_bytes(first + more + rest)
    with open_events(path) as file:
        assert file.header_fields.get("created") == date


def test_wrong_options_are_refused(tmp_path: Path) -> None:
    path = make_file(tmp_path, "a.txt", E)
    for options, message in (
        ({"format": "aedat5"}, "Allowed is one of aedat4"),
        ({"size": (0, 5)}, "0x5"),
        ({"time_unit": "min"}, "Allowed is one of s, ms, us, ns"),
        ({"format": "hdf5"}, "truncated or damaged"),
        ({"format": "dat", "columns": "txyp"}, "is Prophesee DAT, which defines its columns"),
    ):
        with pytest.raises(FormatError, match=message):
            read_events(path, **options)


def test_a_missing_library_is_named_with_the_install_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = make_file(tmp_path, "a.es", E)
    (tmp_path / "without").mkdir()
    (tmp_path / "without" / "faery.py").write_text("raise ImportError('not here')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "without"))
    with pytest.raises(FormatError, match=r"pip install 'flybench\[formats\]'"):
        read_events(path)


def test_a_recording_of_dv_is_read(tmp_path: Path) -> None:
    import dv_processing as dv

    clock_us, events = 1_700_000_000_000_000, random_events()
    config = dv.io.MonoCameraWriter.DAVISConfig(
        "DAVIS346_00000001", SIZE
    )  # with streams for IMU samples and triggers
    writer = dv.io.MonoCameraWriter(str(tmp_path / "dv.aedat4"), config)
    store = dv.EventStore()
    for t, x, y, p in events.tolist():
        store.push_back(clock_us + t, x, y, p)
    writer.writeEvents(store)
    image = np.arange(260 * 346).reshape(260, 346).astype(np.uint8)
    for start_us in (0, 40_000):
        writer.writeFrame(dv.Frame(clock_us + start_us, 9_000, 0, 0, image, dv.FrameSource.SENSOR))
    del writer
    with open_events(tmp_path / "dv.aedat4") as file:
        chunks = list(file)
    first_us = int(events["t"][0])
    assert file.origin_us == clock_us + first_us
    assert (file.width, file.height) == SIZE
    assert np.array_equal(chunks[0].events["t"], events["t"] - first_us)
    (frame,) = (
        frame for chunk in chunks for frame in chunk.frames
    )  # the other began before the first event
    assert (frame.start_us, frame.end_us) == (40_000 - first_us, 49_000 - first_us)
    assert np.array_equal(frame.image, image.astype(np.uint16) * 4)


def test_more_events_than_fit_into_memory_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "many.npz"
    write_events(path, [np.zeros(100_000, EVENT_DTYPE)], width=4, height=4)
    monkeypatch.setattr("flybench.memory._counted", {})
    monkeypatch.setattr("flybench.memory._counted", {})
    monkeypatch.setenv("FLYBENCH_MEMORY_GB", "0.001")
    with pytest.raises(MemoryBudgetError, match="The list of the first 100000 events"):
        read_events(path)
