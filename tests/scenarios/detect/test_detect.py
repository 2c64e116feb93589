"""`flybench detect`, from a file to what it prints and writes."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import tyro

from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import EVENT_DTYPE, Events
from formats import Chunk, open_writer, write_events
from scenarios.commands.detect import Detect
from scenarios.commands.view import MAGIC
from scenarios.output.terminal import execute
from scenarios.pipeline.registry import DETECTORS
from tests.detector.stimuli import asphalt, slide, textured_box, turned
from tests.scenarios.rrd_contents import RrdContents

SIZE: Any = {"width": 346, "height": 260}


@pytest.fixture(scope="module")
def events() -> Events:
    drawn = slide(
        textured_box(),
        speed_px_s=400.0,
        start_px=60.0,
        top_px=100,
        duration_us=300_000,
        background=asphalt(260, 346),
    )
    return turned(drawn, Direction.LEFT, **SIZE)


@pytest.fixture(scope="module")
def recording(events: Events, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("events") / "leftward.npz"
    write_events(path, [events], **SIZE)
    return path


def test_a_table_and_a_verdict(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(Detect(recording)) == 0
    said = capsys.readouterr().out
    assert "← left" in said.splitlines()[-2]
    for words in ("346 × 260 px", "npz", "kev/s", "ON, OFF", "strength"):
        assert words in said


def test_json_is_all_that_stands_on_standard_output(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rrd, png = tmp_path / "a.rrd", tmp_path / "a.png"
    assert execute(Detect(recording, json=True, rrd=rrd, plot=png)) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["direction"] == "left"
    assert len(said["steps"]) > 8
    assert set(said["steps"][0]) == {"t_us", "hs", "vs", "direction", "strength"}
    strongest = max(said["steps"], key=lambda step: step["strength"])
    assert strongest["direction"] == "left"
    assert strongest["hs"] < -abs(strongest["vs"])
    assert said["file"]["events"] > 1000
    picture = cv2.imread(str(png))
    assert picture is not None
    assert picture.std() > 10
    _check_recording(rrd, said["steps"], said["file"]["events"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "a.rrd"]


def _check_recording(rrd: Path, steps: list[dict[str, Any]], events: int) -> None:
    reading = RrdContents(rrd)
    shown = reading.rows("/response/hs/fly", "Scalars:scalars")
    assert [value for _, (value,) in shown] == pytest.approx([step["hs"] for step in steps])
    assert [t for t, _ in shown] == pytest.approx([step["t_us"] * 1e-6 for step in steps])
    counts = sum(len(p) for p in reading.values("/world/camera/events", "Points2D:positions"))
    assert counts == events
    entities = {chunk.entity_path for chunk in reading.chunks}
    assert not any("truth" in path or "street" in path for path in entities)
    assert "/world/camera/methods/fly/saliency" in entities


def test_a_runs_folder_will_do(
    events: Events, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_events(tmp_path / "events.h5", [events], **SIZE)
    assert execute(Detect(tmp_path, json=True, method="wide")) == 0
    assert json.loads(capsys.readouterr().out)["direction"] == "left"


def test_frames_of_the_file_reach_a_method_that_looks_at_frames(
    events: Events, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(0)
    wall = cv2.GaussianBlur(rng.uniform(0, 1000, (260, 1000)).astype(np.float32), (0, 0), 6)
    wall = 512 + 8 * (wall - wall.mean())
    file = tmp_path / "frames.aedat4"
    with open_writer(file, **SIZE) as writer:
        writer.write(events[:1000])
        for k in range(12):
            seen = wall[:, 300 - 8 * k : 646 - 8 * k].clip(0, 1020).astype(np.uint16)
            writer.write_frame(ApsFrame(25_000 * k, 25_000 * k + 7000, np.ascontiguousarray(seen)))
    assert execute(Detect(file, method="frame-fly", json=True)) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["file"]["frames"] == 12
    assert len(said["steps"]) == 11
    assert said["direction"] == "right"


def test_an_interrupted_copy_leaves_a_sentence_and_nothing_else(
    events: Events, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "cut.aedat4"
    write_events(file, [events], **SIZE)
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    outputs: Any = {"rrd": tmp_path / "a.rrd", "plot": tmp_path / "a.png"}
    assert execute(Detect(file, json=True, **outputs)) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("flybench: ")
    assert said.err.count("\n") == 1
    assert str(file) in said.err
    assert [path.name for path in tmp_path.iterdir()] == ["cut.aedat4"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"file": Path("nowhere.raw")}, "nowhere.raw does not exist"),
        ({"method": "bee"}, "The method is 'bee'. Allowed is fly"),
        ({"method": "frame-fly"}, "looks at frames, and .* holds none; choose another"),
        ({"size": "346"}, "--size is '346'; .* write it as --size 346x260"),
        ({"size": "20x20"}, r"allowed is 0 to 19; .* --size"),
        ({"time_scale": 0.0}, "--time-scale is 0.0. Allowed is a number from 0.001 to 1000"),
        ({"time_scale": 3000.0}, "--time-scale is 3000.0"),
        ({"rrd": Path("no/folder/a.rrd")}, "--rrd no/folder/a.rrd has no folder .* make"),
        ({"rrd": Path("a.png")}, "allowed is a name that ends in .rrd"),
        ({"plot": Path("a.pdf")}, "allowed is a name that ends in .png"),
        ({"method": "scenarios:Nobody", "scale_to_sensor": True}, "no class Nobody"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(
    recording: Path, changes: Any, words: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        assert execute(replace(Detect(recording), **changes)) == 2
    said = capsys.readouterr().err
    assert said.startswith("flybench: ")

    assert re.search(words, said)
    assert list(tmp_path.iterdir()) == []


def test_a_file_without_events_is_told_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "none.npz"
    write_events(file, [Chunk(np.empty(0, EVENT_DTYPE))], **SIZE)
    assert execute(Detect(file, plot=tmp_path / "a.png")) == 2
    assert "none.npz" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["none.npz"]


def test_who_gives_a_rerun_recording_is_sent_to_view(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.rrd"
    file.write_bytes(MAGIC + bytes(100))
    assert execute(Detect(file)) == 2
    assert f"open it with: flybench view {file}" in capsys.readouterr().err


def test_help_names_every_method(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        tyro.cli(Detect, args=["--help"])
    told = re.sub(r"[\s│]+", " ", capsys.readouterr().out)
    for name in DETECTORS:
        assert f" {name}," in told


def test_a_recording_is_not_overwritten_by_its_own_picture(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "events.rrd"
    shutil.copy(recording, file)
    assert execute(Detect(file, rrd=file)) == 2
    assert "--rrd is the recording itself" in capsys.readouterr().err
    assert file.read_bytes() == recording.read_bytes()
