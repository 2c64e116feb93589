"""`flybench detect`: what it prints and writes, and its errors."""

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from detector import MotionEstimate
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import EVENT_DTYPE, Events
from formats import Chunk, open_writer, write_events
from scenarios.commands.compare import Compare
from scenarios.commands.detect import Detect
from scenarios.commands.view import MAGIC
from scenarios.options.recording import RecordingOptions
from scenarios.output.terminal import execute
from tests.detector.stimuli import asphalt, slide, textured_box, turned
from tests.scenarios.rrd_contents import RrdContents

SIZE: Any = {"width": 346, "height": 260}


@pytest.fixture(scope="module")
def events() -> Events:
    rightward = slide(
        textured_box(),
        speed_px_s=400.0,
        start_px=60.0,
        top_px=100,
        duration_us=300_000,
        background=asphalt(260, 346),
    )
    return turned(rightward, Direction.LEFT, **SIZE)


@pytest.fixture(scope="module")
def recording(events: Events, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("events") / "leftward.npz"
    write_events(path, [events], **SIZE)
    return path


def test_it_prints_estimates_and_verdict(
    recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert execute(Detect(recording)) == 0
    out = capsys.readouterr().out
    assert "← left: " in out
    unwrapped = " ".join(out.replace("│", " ").split())
    assert re.search(r"(\d+) of \d+ steps name a direction, \1 of these left", unwrapped)
    for words in ("346 × 260 px", "npz", "kev/s", "ON, OFF", "strength", "spans", "left 0."):
        assert words in out


def test_a_filter_stands_before_the_detector(
    recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    documents = []
    for options in ({}, {"filter": "stcf"}, {"method": "stcf+robust"}):
        arguments: Any = {"json": True} | options
        assert execute(Detect(recording, **arguments)) == 0
        documents.append(json.loads(capsys.readouterr().out))
    plain, by_option, by_name = documents
    assert by_option == by_name
    assert by_option["method"] == "stcf+robust"
    assert by_option["steps"] != plain["steps"]


def test_with_json_standard_output_is_one_document(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rrd, png = tmp_path / "a.rrd", tmp_path / "a.png"
    assert execute(Detect(recording, json=True, rrd=rrd, plot=png)) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["error"] is None
    assert document["direction"] == document["verdict"] == "left"
    assert len(document["steps"]) > 8
    assert document["counts"]["left"] == sum(s["direction"] == "left" for s in document["steps"])
    assert {span["direction"] for span in document["spans"]} == {"left"}
    assert set(document["steps"][0]) == {"t_us", "hs", "vs", "direction", "strength"}
    strongest = max(document["steps"], key=lambda step: step["strength"])
    assert strongest["direction"] == "left"
    assert strongest["hs"] < -abs(strongest["vs"])
    assert document["file"]["events"] > 1000
    picture = cv2.imread(str(png))
    assert picture is not None
    assert picture.std() > 10
    _check_recording(rrd, document["steps"], document["file"]["events"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "a.rrd"]


def _check_recording(rrd: Path, steps: list[dict[str, Any]], events: int) -> None:
    reading = RrdContents(rrd)
    logged = reading.rows("/response/hs/robust", "Scalars:scalars")
    assert [value for _, (value,) in logged] == pytest.approx([step["hs"] for step in steps])
    assert [t for t, _ in logged] == pytest.approx([step["t_us"] * 1e-6 for step in steps])
    counts = sum(len(p) for p in reading.values("/world/camera/events", "Points2D:positions"))
    assert counts == events
    entities = {chunk.entity_path for chunk in reading.chunks}
    assert not any("truth" in path or "street" in path for path in entities)
    assert "/world/camera/methods/robust/saliency" in entities


def test_it_reads_the_folder_of_a_run(
    events: Events, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_events(tmp_path / "events.h5", [events], **SIZE)
    assert execute(Detect(tmp_path, json=True, method="wide")) == 0
    assert json.loads(capsys.readouterr().out)["direction"] == "left"


def test_frames_of_the_file_reach_a_frame_detector(
    events: Events, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(0)
    wall = cv2.GaussianBlur(rng.uniform(0, 1000, (260, 1000)).astype(np.float32), (0, 0), 6)
    wall = 512 + 8 * (wall - wall.mean())
    file = tmp_path / "frames.aedat4"
    with open_writer(file, **SIZE) as writer:
        writer.write(events[:1000])
        for k in range(12):
            image = wall[:, 300 - 8 * k : 646 - 8 * k].clip(0, 1020).astype(np.uint16)
            writer.write_frame(ApsFrame(25_000 * k, 25_000 * k + 7000, np.ascontiguousarray(image)))
    assert execute(Detect(file, method="frame-fly", json=True)) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["file"]["frames"] == 12
    assert len(document["steps"]) == 11
    assert document["direction"] == "right"


class Moving:
    """A detector that changes the current folder."""

    folder = Path()

    def __init__(self, *, width: int, height: int) -> None:
        self.size = width, height
        os.chdir(self.folder)

    def push(self, _: Events) -> list[MotionEstimate]:
        return []

    def advance(self, _: int) -> list[MotionEstimate]:
        return []


def test_a_detector_that_changes_the_folder_does_not_move_the_outputs(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Moving, "folder", tmp_path / "elsewhere")
    method = f"{__name__}:{Moving.__name__}"
    outputs: Any = {"rrd": Path("a.rrd"), "plot": Path("a.png")}
    assert execute(Detect(recording, method=method, **outputs)) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "a.rrd", "elsewhere"]
    assert list((tmp_path / "elsewhere").iterdir()) == []


@pytest.mark.parametrize("name", ["a$b_{$.npz", "a\udcff.npz"])
def test_any_file_name_can_be_drawn_and_recorded(
    recording: Path, tmp_path: Path, name: str
) -> None:
    file = tmp_path / name
    shutil.copy(recording, file)
    outputs: Any = {"rrd": tmp_path / "a.rrd", "plot": tmp_path / "a.png"}
    assert execute(Detect(file, **outputs)) == 0
    assert execute(Compare(file, file, plot=tmp_path / "b.png")) == 0
    assert {path.name for path in tmp_path.iterdir()} == {name, "a.rrd", "a.png", "b.png"}


def test_a_file_without_readable_events_gives_an_error_and_no_output(
    events: Events, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "truncated.aedat4"
    write_events(file, [events], **SIZE)
    file.write_bytes(file.read_bytes()[:1000])
    outputs: Any = {"rrd": tmp_path / "a.rrd", "plot": tmp_path / "a.png"}
    assert execute(Detect(file, json=True, **outputs)) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.fullmatch(rf"(aedat4, .*\n)?flybench: .*{re.escape(str(file))}.*\n", captured.err)
    assert [path.name for path in tmp_path.iterdir()] == ["truncated.aedat4"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"file": Path("nowhere.raw")}, "nowhere.raw does not exist"),
        ({"method": "bee"}, "The method is 'bee'. Allowed is fly"),
        ({"method": "frame-fly"}, "needs APS frames, and .* contains none. Choose another"),
        ({"input": RecordingOptions(size="346")}, "--size is '346'. .* such as --size 346x260"),
        ({"input": RecordingOptions(size="20x20")}, r"so that 0 to 19 is allowed. .* --size"),
        ({"time_scale": 0.0}, "--time-scale is 0.0. Allowed is a number from 0.001 to 1000"),
        ({"time_scale": 3000.0}, "--time-scale is 3000.0"),
        (
            {"rrd": Path("no/folder/a.rrd")},
            "--rrd no/folder/a.rrd cannot be written: .* Create",
        ),
        ({"rrd": Path("a.png")}, "Allowed is a name that ends in .rrd"),
        ({"plot": Path("a.pdf")}, "Allowed is a name that ends in .png"),
        ({"method": "tests.scenarios.reading:Nobody", "scale_to_sensor": True}, "Nobody"),
    ],
)
def test_invalid_arguments_give_a_one_line_error(
    recording: Path, changes: Any, words: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        assert execute(replace(Detect(recording), **changes)) == 2
    err = capsys.readouterr().err
    assert err.startswith("flybench: ")
    assert re.search(words, err)
    assert list(tmp_path.iterdir()) == []


def test_the_table_covers_what_comes_before_a_late_event(
    events: Events, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    late = events.copy()
    late["t"][events.size // 2] -= 5000
    np.save(tmp_path / "a.npy", late)
    assert execute(Detect(tmp_path / "a.npy")) == 2
    captured = capsys.readouterr()
    assert f"{events.size // 2:,} in" in captured.out
    assert "← left" in captured.out
    assert "--sort 5, or drop them" in captured.err
    assert captured.out.startswith("npy, 286 × 150 px, from the events, times in µs, because")
    options = RecordingOptions(sort=6.0, size="346x260")
    assert execute(Detect(tmp_path / "a.npy", json=True, input=options)) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["file"]["events"] == events.size
    assert document["file"]["sorted_events"] == 1
    assert document["file"]["dropped_events"] is None


def test_what_comes_before_an_error_is_in_all_outputs(
    events: Events, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    late, count = events.copy(), events.size // 2
    late["t"][count] -= 5000
    np.save(tmp_path / "a.npy", late)
    rrd, png = tmp_path / "a.rrd", tmp_path / "a.png"
    options = RecordingOptions(size="346x260")
    assert execute(Detect(tmp_path / "a.npy", json=True, rrd=rrd, plot=png, input=options)) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("npy, 346 × 260 px, from the option, times in µs, because")
    document = json.loads(captured.out)
    assert f"event {count} has the time" in document["error"]
    assert document["error"] in captured.err
    assert document["failed"] is None
    assert document["file"]["events"] == count
    assert document["verdict"] == "left"
    _check_recording(rrd, document["steps"], count)
    assert cv2.imread(str(png)) is not None


def test_a_file_without_events_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "empty.npz"
    write_events(file, [Chunk(np.empty(0, EVENT_DTYPE))], **SIZE)
    assert execute(Detect(file, plot=tmp_path / "a.png")) == 2
    assert "empty.npz" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["empty.npz"]


def test_for_a_rerun_recording_the_error_names_flybench_view(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.rrd"
    file.write_bytes(MAGIC + bytes(100))
    assert execute(Detect(file)) == 2
    assert f"View it with: flybench view {file}" in capsys.readouterr().err


def test_an_output_may_not_overwrite_the_recording(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "events.rrd"
    shutil.copy(recording, file)
    assert execute(Detect(file, rrd=file)) == 2
    assert "which is a file to read" in capsys.readouterr().err
    assert file.read_bytes() == recording.read_bytes()


def test_a_file_of_the_user_is_replaced_only_with_overwrite(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, suffix in (("plot", ".png"), ("rrd", ".rrd")):
        mine = tmp_path / f"mine{suffix}"
        mine.write_text("mine")
        changes: Any = {name: mine}
        command = replace(Detect(recording), **changes)
        assert execute(command) == 2
        assert "exists already. Allowed is a new file." in capsys.readouterr().err
        assert mine.read_text() == "mine"
        assert execute(replace(command, overwrite=True)) == 0
        assert mine.read_bytes() != b"mine"


WITH_LITTLE_ROOM = """
import resource, signal, sys
from pathlib import Path
from scenarios.commands.compare import Compare
from scenarios.commands.detect import Detect
from scenarios.output.terminal import execute
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
output = Path(sys.argv[2])
sys.exit(execute(Detect(Path(sys.argv[1]), **{sys.argv[3]: output})))
"""


@pytest.mark.parametrize(("option", "name"), [("rrd", "a.rrd"), ("plot", "a.png")])
def test_a_full_disk_is_one_sentence(
    recording: Path, tmp_path: Path, option: str, name: str
) -> None:
    path = tmp_path / name
    command = [sys.executable, "-c", WITH_LITTLE_ROOM, str(recording), str(path), option]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == (
        f"flybench: The disk of {path} is full. Free some space, or choose another place.\n"
    )
    assert list(tmp_path.iterdir()) == []
