"""`flybench compare`: what it prints and writes, and its errors."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from emulator import ApsFrame
from formats import Chunk, open_writer, write_events
from scenarios.commands.compare import Compare
from scenarios.commands.view import MAGIC
from scenarios.options.recording import RecordingOptions
from scenarios.output.terminal import execute
from tests.scenarios.event_statistics.made_events import (
    SIZE,
    edge_events,
    events_of,
    noise_events,
)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """One recording with frames, and one without."""
    folder = tmp_path_factory.mktemp("events")
    real, emulated = folder / "real.aedat4", folder / "emulated.npz"
    image = np.linspace(0, 1000, SIZE["width"] * SIZE["height"]).reshape(24, 32)
    with open_writer(real, **SIZE) as writer:
        writer.write(noise_events(3.0, 500_000))
        writer.write_frame(ApsFrame(0, 10_000, image.astype(np.uint16)))
    write_events(emulated, [edge_events(px_s=200.0, events_each=3)], **SIZE)
    return real, emulated


def test_it_prints_every_statistic_with_its_distance(
    recordings: tuple[Path, Path], capsys: pytest.CaptureFixture[str], monkeypatch: Any
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert execute(Compare(*recordings)) == 0
    out = capsys.readouterr().out
    for words in (
        r"A: .*real\.aedat4, 2,\d+ events in 0\.\d+ s",
        r"ON events +\d+\.\d % +100\.0 % +0\.\d\d +\|B − A\|",
        r"events per pixel and edge +1\.\d\d +3\.00 +\d",
        r"interval, 1st percentile .* µs .* \|ln\(B/A\)\|",
        r"noise, 1/2–2 of mean",
        r"row changes downwards",
        r"B has no APS frames",
    ):
        assert re.search(words, out), words
    assert all(len(line.rstrip()) <= 80 for line in out.splitlines()[2:])


def test_with_json_standard_output_is_one_document(
    recordings: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    png = tmp_path / "figure.png"
    assert execute(Compare(*recordings, json=True, plot=png)) == 0
    document = json.loads(capsys.readouterr().out)
    rows = {row["key"]: row for row in document["comparison"]}
    assert rows["events_an_edge"]["b"] == 3.0
    assert rows["events_an_edge"]["measure"] == "|ln(B/A)|"
    assert document["b"]["edges_by_events"] == [0, 0, 0, 24 * 32]
    intervals = document["b"]["intervals_us"]["same_polarity"]
    assert [count for low, high, count in intervals if low <= 2000 < high] == [2 * 24 * 32]
    assert document["a"]["frames"] == 1
    assert len(document["a"]["readout"]) == 6
    picture = cv2.imread(str(png))
    assert picture is not None
    assert picture.std() > 10
    assert [path.name for path in tmp_path.iterdir()] == ["figure.png"]


def test_events_that_were_dropped_are_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "late.csv"
    file.write_text("t,x,y,p\n10,1,1,1\n900,2,2,0\n30,1,2,1\n950,3,3,1\n")
    options = RecordingOptions(size="32x24", drop_unsorted=True)
    assert execute(Compare(file, file, input=options)) == 0
    assert "3 events in 0.001 s" in (out := capsys.readouterr().out)
    assert out.count("1 event out of order dropped") == 2


def test_the_figure_can_be_drawn_of_almost_nothing(tmp_path: Path) -> None:
    a, png = tmp_path / r"a$\x$.npz", tmp_path / "figure.png"
    write_events(a, [events_of((0, 1, 1, 1), (9, 2, 20, 0))], **SIZE)
    assert execute(Compare(a, a, plot=png)) == 0
    assert png.is_file()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"a": Path("nowhere.raw")}, "nowhere.raw does not exist"),
        ({"b": Path("nowhere.raw")}, "nowhere.raw does not exist"),
        ({"input": RecordingOptions(size="32")}, "--size is '32'. .* such as --size 346x260"),
        ({"plot": Path("a.pdf")}, "Allowed is a name that ends in .png"),
        ({"plot": Path("no/folder/a.png")}, "--plot no/folder/a.png cannot be written: .* Create"),
    ],
)
def test_invalid_arguments_give_a_one_line_error(
    recordings: tuple[Path, Path],
    changes: Any,
    words: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        assert execute(replace(Compare(*recordings), **changes)) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.fullmatch(rf"flybench: .*{words}.*\n", captured.err)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("events", [events_of(), events_of((5, 1, 1, 1), (5, 2, 1, 1))])
def test_a_recording_of_no_duration_is_an_error(
    events: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "short.npz"
    write_events(file, [Chunk(events)], **SIZE)
    assert execute(Compare(file, file, plot=tmp_path / "a.png")) == 2
    assert f"{events.size} events in 0 s" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["short.npz"]


def test_for_a_rerun_recording_the_error_names_flybench_view(
    recordings: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.rrd"
    file.write_bytes(MAGIC + bytes(100))
    assert execute(Compare(recordings[0], file)) == 2
    assert f"View it with: flybench view {file}" in capsys.readouterr().err


def test_the_figure_may_not_overwrite_a_recording(
    recordings: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "events.png"
    file.write_bytes(recordings[1].read_bytes())
    assert execute(Compare(recordings[0], file, plot=file)) == 2
    assert "which is a file to read" in capsys.readouterr().err
    assert file.read_bytes() == recordings[1].read_bytes()
