"""`flybench convert`."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flybench.errors import FlybenchError
from flybench.events import Events, concatenate_events
from formats import ENDINGS, open_events, read_events
from scenarios.commands.convert import Convert
from scenarios.commands.detect import Detect
from scenarios.options.recording import RecordingOptions
from scenarios.output.terminal import execute
from tests.formats.sample_files import (
    FILE_MAKERS,
    SIZE,
    WITHOUT_SIZE,
    make_file,
    random_events,
    random_frames,
)
from tests.formats.test_samples import write_with_dv

E = random_events(3000)


@pytest.mark.parametrize("name", FILE_MAKERS)
def test_every_format_is_converted(tmp_path: Path, name: str) -> None:
    source, out = make_file(tmp_path, name, E), tmp_path / "out.aedat4"
    options = RecordingOptions("346x260" if name in WITHOUT_SIZE else None)
    assert Convert(source, out, input=options).execute() == 0
    with open_events(out) as file:
        chunks = list(file)
    assert (file.width, file.height, file.size_source) == (*SIZE, "the file")
    assert np.array_equal(concatenate_events([c.events for c in chunks]), E)
    frames = [frame for chunk in chunks for frame in chunk.frames]
    written = random_frames() if name == "a.aedat4" else []
    assert [f.end_us for f in frames] == [f.end_us for f in written]
    assert all(np.array_equal(a.image, b.image) for a, b in zip(frames, written, strict=True))


@pytest.mark.parametrize("ending", ENDINGS)
def test_every_format_is_written(tmp_path: Path, ending: str) -> None:
    source, out = make_file(tmp_path, "a.npz", E), tmp_path / f"out{ending}"
    assert Convert(source, out).execute() == 0
    assert np.array_equal(read_events(out), E)


def test_a_ros2_bag_is_written_as_a_folder(tmp_path: Path) -> None:
    source = make_file(tmp_path, "a.npz", E)
    assert Convert(source, tmp_path / "bag", out_format="rosbag2").execute() == 0
    assert sorted(p.name for p in (tmp_path / "bag").iterdir()) == ["bag.mcap", "metadata.yaml"]
    assert np.array_equal(read_events(tmp_path / "bag"), E)


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.split("│")[1:-1]]


def test_a_section_is_cut_in_time_and_space(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, out = make_file(tmp_path, "a.aedat4", E), tmp_path / "out.aedat4"
    cut = Convert(source, out, from_s=0.02, to_s=0.06, crop="100,50,300,200")
    assert cut.execute() == 0
    in_time = (E["t"] >= 20_000) & (E["t"] < 60_000)
    inside = (E["x"] >= 100) & (E["x"] < 300) & (E["y"] >= 50) & (E["y"] < 200)
    expected = E[in_time & inside].copy()
    expected["x"] -= 100
    expected["y"] -= 50
    with open_events(out) as file:
        chunks = list(file)
    assert (file.width, file.height) == (200, 150)
    assert np.array_equal(concatenate_events([c.events for c in chunks]), expected)
    frame, _ = (frame for chunk in chunks for frame in chunk.frames)
    assert (frame.start_us, frame.end_us) == (25_000, 34_000)
    assert np.array_equal(frame.image, random_frames()[1].image[50:200, 100:300])
    rows = {row[0]: row[1:] for row in map(cells, capsys.readouterr().out.splitlines()) if row}
    outside = (f"{(~in_time).sum():,}", f"{(in_time & ~inside).sum():,}")
    assert rows["events"] == ["3,000", *outside, f"{expected.size:,}"]
    assert rows["frames"] == ["3", "1", "0", "2"]


def test_the_end_of_a_section_is_not_read_beyond(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    events = random_events(300_000)
    source = make_file(tmp_path, "a.csv", events)
    source.write_bytes(source.read_bytes()[:-2])
    with pytest.raises(FlybenchError, match="may be truncated"):
        Convert(source, tmp_path / "out.npz").execute()
    assert not (tmp_path / "out.npz").exists()
    assert Convert(source, tmp_path / "out.npz", to_s=0.01).execute() == 0
    assert np.array_equal(read_events(tmp_path / "out.npz"), events[events["t"] < 10_000])
    capsys.readouterr()
    assert Convert(source, tmp_path / "all.npz", salvage=True).execute() == 0
    assert np.array_equal(read_events(tmp_path / "all.npz"), events[:-1])
    assert "flybench: warning" in capsys.readouterr().err


def test_late_events_are_sorted_or_dropped_and_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    late = E.copy()
    late["t"][1500] -= 2000
    source, out = tmp_path / "a.npy", tmp_path / "out.npz"
    np.save(source, late)
    with pytest.raises(FlybenchError, match=r"--sort 2, or drop them with --drop-unsorted"):
        Convert(source, out, input=RecordingOptions("346x260")).execute()
    assert not out.exists()
    assert Convert(source, out, input=RecordingOptions("346x260", sort=3.0)).execute() == 0
    assert np.array_equal(read_events(out), late[np.argsort(late["t"], kind="stable")])
    assert "1 late event" in capsys.readouterr().out
    options = RecordingOptions("346x260", drop_unsorted=True)
    assert Convert(source, out, input=options, overwrite=True).execute() == 0
    assert np.array_equal(read_events(out), np.delete(late, 1500))
    assert "1 event out of order" in capsys.readouterr().out


def test_late_events_before_damage_are_counted_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, out = make_file(tmp_path, "a.csv", E), tmp_path / "out.npz"
    lines = source.read_text().splitlines(keepends=True)
    lines[10:12] = lines[11:9:-1]
    source.write_text("".join(lines)[:-2])
    options = RecordingOptions(sort=3.0)
    assert Convert(source, out, salvage=True, input=options).execute() == 0
    assert np.array_equal(read_events(out), E[:-1])
    assert "1 late event" in capsys.readouterr().out


def test_what_the_format_cannot_contain_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_with_dv(tmp_path / "a.aedat4")
    assert Convert(tmp_path / "a.aedat4", tmp_path / "a.csv").execute() == 0
    text = "note: 40 IMU samples and 2 triggers were not written."
    assert text in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"from_s": 5.0}, r"no event in that section.* from 0\.0000\d\d s to 0\.0999"),
        ({"from_s": 2.0, "to_s": 1.0}, r"--from is 2 and --to is 1"),
        ({"to_s": float("nan")}, r"--to is nan. Allowed is 0 to"),
        ({"crop": "1,2,3"}, r"--crop is '1,2,3'. Allowed is X0,Y0,X1,Y1 with X0 < X1 <= 346"),
        ({"crop": "0,0,347,260"}, r"X1 <= 346 and Y0 < Y1 <= 260"),
        ({"out": Path("out.xyz")}, r"ends in \.xyz. Allowed is one of"),
        ({"out_format": "mat"}, r"The format is 'mat'"),
    ],
)
def test_refusals(tmp_path: Path, change: dict[str, object], message: str) -> None:
    source = make_file(tmp_path, "a.npz", E)
    arguments = {"out": Path("out.npz")} | change
    arguments["out"] = tmp_path / str(arguments["out"])
    with pytest.raises(FlybenchError, match=message):
        Convert(source, **arguments).execute()  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == [source]


def test_the_recording_is_not_overwritten(tmp_path: Path) -> None:
    source = make_file(tmp_path, "a.npz", E)
    (tmp_path / "link.npz").symlink_to(source)
    for path in (source, tmp_path / "link.npz"):
        with pytest.raises(FlybenchError, match="which is the recording to read"):
            Convert(path, source).execute()
    assert np.array_equal(read_events(source), E)
    bag = tmp_path / "bag"
    assert Convert(source, bag, out_format="rosbag2").execute() == 0
    with pytest.raises(FlybenchError, match="the recording to read, or part of it"):
        Convert(bag, bag / "bag.mcap", to_s=0.01).execute()
    assert np.array_equal(read_events(bag), E)


def test_the_share_that_was_read_grows_to_1(tmp_path: Path) -> None:
    path = tmp_path / "a.npy"
    np.save(path, random_events(2_000_000))
    with open_events(path, size=SIZE) as file:
        found = [file.read_share for _ in file]
    shares = [share for share in found if share is not None]
    if shares:  # on Linux
        assert shares == sorted(shares)
        assert shares[0] < 0.5
        assert shares[-1] > 0.8


def test_detect_takes_the_same_input_options(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    events: Events = E.copy()
    events["t"] //= 1000
    source = make_file(tmp_path, "a.npz", events)
    options = RecordingOptions(size="346x260", format="npz", time_unit="ms")
    assert Detect(source, json=True, input=options).execute() == 0
    found = json.loads(capsys.readouterr().out)["file"]
    assert (found["size_source"], found["last_us"]) == ("the option", int(events["t"][-1]) * 1000)
    assert Convert(source, tmp_path / "b.npz", input=options).execute() == 0
    assert np.array_equal(read_events(tmp_path / "b.npz")["t"], events["t"] * 1000)


def test_a_file_of_the_user_is_replaced_only_with_overwrite(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, mine = make_file(tmp_path, "a.csv", E), tmp_path / "mine.mcap"
    mine.write_text("mine")
    command = Convert(source, mine)
    assert execute(command) == 2
    assert "exists already" in capsys.readouterr().err
    assert mine.read_text() == "mine"
    assert execute(replace(command, overwrite=True)) == 0
    assert mine.is_file()
    assert np.array_equal(read_events(mine), E)
