"""`flybench run` as a user calls it: files, summary, refused values and reproducibility."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from detector.fly.detector import FlyDetector
from detector.plane_fit.detector import PlaneFit
from formats import open_events, read_events
from scenarios.commands.run import Run
from scenarios.output.tables import estimate_row
from scenarios.runs.run_table import print_runs
from scenarios.runs.sequence import RunParts, record_run
from tests.scenarios.in_process import exit_status

COARSE = ("--step-px", "8", "--supersample", "1", "--omega", "4.0")


def flybench(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "scenarios.cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def finished_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    folder = tmp_path_factory.mktemp("runs") / "one"
    more = ("--events-format", "aedat4", "evt3")
    done = flybench("run", *COARSE, "--seed", "7", *more, "--out", str(folder))
    assert done.returncode == 0, done.stderr
    return folder, done.stdout


def summary_of(folder: Path) -> Any:
    return json.loads((folder / "summary.json").read_text())


def test_the_folder_holds_the_documented_files(finished_run: tuple[Path, str]) -> None:
    folder, _ = finished_run
    names = {path.name for path in folder.iterdir()}
    documented = {"recording.rrd", "events.h5", "truth.csv", "estimates.csv", "summary.json"}
    assert names == documented | {"events.aedat4", "events.raw"}


def test_a_run_of_only_the_events_replaces_an_earlier_run(
    finished_run: tuple[Path, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It has the events of the earlier one, with causes and sources, and none of its files."""
    folder = Path(shutil.copytree(finished_run[0], tmp_path / "events"))
    run = Run(omega=4.0, step_px=8, supersample=1, seed=7, only_events=True, out=folder)
    assert run.execute() == 0
    assert {path.name for path in folder.iterdir()} == {"events.h5", "truth.csv", "summary.json"}
    assert [path.name for path in tmp_path.iterdir()] == [folder.name]
    assert "wrote" in capsys.readouterr().out
    events = read_events(folder / "events.h5")
    assert np.array_equal(events, read_events(finished_run[0] / "events.h5"))
    with h5py.File(folder / "events.h5") as file:
        cause, source = file["events/cause"], file["events/source"]
        assert cause.attrs["0"] == "signal"
        assert source.attrs["-2"] == "noise"
        causes, sources = cause[:], source[:]
    assert causes.size == sources.size == events.size
    counts = summary_of(finished_run[0])["events"]["by_cause"]
    assert np.count_nonzero(causes == 0) == counts["signal"]
    assert set(sources[causes != 0]) == {-2}
    assert np.mean(sources[causes == 0] == 0) > 0.9  # nothing else moves


def test_additional_formats_hold_equal_events_and_the_aps_frames(
    finished_run: tuple[Path, str],
) -> None:
    events = read_events(finished_run[0] / "events.h5")
    for name in ("events.aedat4", "events.raw"):
        assert np.array_equal(read_events(finished_run[0] / name), events)
    with open_events(finished_run[0] / "events.aedat4") as file:
        frames = [frame for chunk in file for frame in chunk.frames]
    assert len(frames) > 10
    assert frames[0].image.shape == (260, 346)


def test_the_summary_has_the_documented_fields(finished_run: tuple[Path, str]) -> None:
    summary, events = summary_of(finished_run[0]), read_events(finished_run[0] / "events.h5")
    assert summary["truth"]["direction"] == "right"
    assert summary["truth"]["omega_rad_s"] == 4.0
    assert summary["fly"]["direction"] == "right"
    assert 0 <= summary["fly"]["accuracy"] <= 1
    assert summary["events"]["count"] == events.size
    assert summary["events"]["on"] == np.count_nonzero(events["p"])
    assert summary["events"]["on"] + summary["events"]["off"] == events.size
    assert sum(summary["events"]["by_cause"].values()) == events.size
    assert set(summary["wall_s"]) == {"render", "emulate", "detect", "record", "total"}
    assert summary["seed"] == 7
    assert summary["parameters"]["sensor"]["theta_on"] == 0.28
    assert summary["parameters"]["crossing"]["distance_m"] == 6.89
    assert summary["devices"]
    assert summary["parameters"]["fly"]["tau_us"] == 30_000
    assert summary["versions"]["mujoco"].startswith("4.")


def test_the_printed_table_shows_the_result_and_the_view_command(
    finished_run: tuple[Path, str],
) -> None:
    folder, printed = finished_run
    for words in ("true direction", "shot noise", "verdict", "flybench view"):
        assert words in printed
    assert folder.name in printed


def table_of(summary: Any, capsys: pytest.CaptureFixture[str]) -> str:
    print_runs([(Path("again"), summary)])
    return capsys.readouterr().out


def test_another_process_other_chunks_and_a_second_method_give_equal_results(
    finished_run: tuple[Path, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = Run(omega=4.0, step_px=8, supersample=1, seed=7).config()
    parts = RunParts(recording=False)
    summary = record_run(config, tmp_path / "again", also=("plane-fit",), parts=parts)
    events = read_events(finished_run[0] / "events.h5")
    assert np.array_equal(read_events(tmp_path / "again" / "events.h5"), events)
    table = (finished_run[0] / "estimates.csv").read_text()
    assert (tmp_path / "again" / "estimates.csv").read_text() == table
    end_us = summary_of(finished_run[0])["truth"]["duration_us"] + 1
    for name, alone in (("", FlyDetector(config.fly)), ("_plane-fit", PlaneFit())):
        table = (tmp_path / "again" / f"estimates{name}.csv").read_text()
        estimates = alone.push(events) + alone.advance(end_us)
        rows = [",".join(map(str, estimate_row(estimate))) for estimate in estimates]
        assert table.splitlines()[1:] == rows
    assert [one["method"] for one in summary["detectors"]] == ["fly", "plane-fit"]
    assert summary["detectors"][0] == summary["detector"]
    assert "also: plane fit" in table_of(summary, capsys)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--omega", "-1"), ("omega_rad_s is -1.0", "allowed is", "another direction")),
        (("--omega", "0"), ("omega_rad_s is 0.0", "allowed is")),
        (("--omega", "1", "--speed-km-h", "40"), ("--omega is 1.0", "leave the other out")),
        (("--seed", "-3"), ("seed is -3", "allowed is")),
        (("--illuminance-lux", "1e9"), ("illuminance_lux is 1000000000.0", "allowed is")),
        (("--lighting", "moon"), ("moon", "day", "dusk", "night")),
        (("--distractors.wind-grade", "99"), ("wind_grade is 99", "from 0 to 8")),
        (("--also", "wide", "wide"), ("--also names wide", "allowed is each method once")),
        (("--also", "bee"), ("'bee'", "allowed is fly")),
        (("--vehicle", "tank"), ("tank", "sedan", "van", "motorcycle")),
    ],
)
def test_a_bad_value_is_refused_with_a_message(
    arguments: tuple[str, ...],
    words: tuple[str, ...],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert exit_status(["run", *arguments, "--out", str(tmp_path / "out")]) == 2
    printed = capsys.readouterr()
    message = " ".join((printed.err + printed.out).replace("│", " ").split())
    assert "Traceback" not in message
    for word in words:
        assert word.lower() in message.lower()
    assert list(tmp_path.iterdir()) == []


def test_a_folder_not_written_by_flybench_is_not_changed(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("mine")
    done = flybench("run", *COARSE, "--out", str(tmp_path))
    assert done.returncode == 2
    assert "were not written by flybench" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]
