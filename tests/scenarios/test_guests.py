"""Other people's detectors in the commands: what they print, and what is left when they fail."""

import csv
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flybench.events import EVENT_DTYPE
from formats import write_events

NOISY, FAILS = "tests.scenarios.guests:Noisy", "tests.scenarios.guests:Failing"
REASON = f"{FAILS}: advance raised an error after "
WORDS = "a guest was here"
ROOT = Path(__file__).parents[2]


def flybench(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "flybench", *arguments]
    environment = os.environ | {"COLUMNS": "200"}
    return subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=ROOT, env=environment
    )


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> str:
    events = np.zeros(3000, EVENT_DTYPE)
    events["t"], events["x"] = np.arange(3000) * 100 + 5, np.arange(3000) % 346
    path = tmp_path_factory.mktemp("events") / "recording.npz"
    write_events(path, [events], width=346, height=260)
    return str(path)


def test_json_of_a_detector_that_prints_is_one_document(recording: str) -> None:
    done = flybench("detect", recording, "--json", "--method", NOISY)
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert (len(document["steps"]), document["direction"]) == (29, "right")
    assert document["failed"] is None
    kinds = ("at import", "as a child", "at exit", "at creation", "in C", "on descriptor 1")
    for kind in (*kinds, "with 100 events", "until 299906"):
        assert f"{WORDS} {kind}" in done.stderr


def test_estimates_before_an_error_are_kept_by_detect(recording: str, tmp_path: Path) -> None:
    files = ("--plot", str(tmp_path / "a.png"), "--rrd", str(tmp_path / "a.rrd"))
    done = flybench("detect", recording, "--json", "--method", FAILS, *files)
    assert done.returncode == 1
    document = json.loads(done.stdout)
    assert [step["t_us"] for step in document["steps"]] == [n * 10_000 for n in range(1, 10)]
    assert document["failed"].startswith(REASON)
    assert "KeyError: 'wings' (guests.py, line" in document["failed"]
    assert document["file"]["events"] == 3000
    assert f"flybench: {document['failed']}\n" in done.stderr
    assert "Traceback" not in done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "a.rrd"]
    table = flybench("detect", recording, "--method", FAILS)
    assert table.returncode == 1
    assert re.search(rf"│ failed +│ {re.escape(REASON)}", table.stdout)


def test_a_run_keeps_the_other_methods_when_one_fails(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    coarse = ("--omega", "4", "--lead-s", "0.05", "--step-px", "8", "--supersample", "1")
    methods = ("--method", FAILS, "--also", "plane-fit", NOISY)
    done = flybench("run", *coarse, *methods, "--out", str(folder))
    assert done.returncode == 1
    assert f"flybench: {REASON}" in done.stderr
    assert "Traceback" not in done.stderr
    assert WORDS not in done.stdout
    lines = [" ".join(line.strip("│").split()) for line in done.stdout.splitlines()]
    for line in (f"method │ {FAILS}", "verdict │ failed", f"also: {NOISY} │ right, 100 % correct"):
        assert line in lines
    summary: Any = json.loads((folder / "summary.json").read_text())
    failed, plane_fit, noisy = summary["detectors"]
    assert summary["detector"] == failed
    assert set(failed) == {"method", "failed", "estimates"}
    assert failed["failed"].startswith(REASON)
    assert plane_fit["accuracy"] > 0.5
    assert noisy["accuracy"] == 1.0
    with (folder / "estimates.csv").open(newline="") as file:
        times_us = [int(row["t_us"]) for row in csv.DictReader(file)]
    assert times_us == [n * 10_000 for n in range(1, failed["estimates"] + 1)]
    assert 8 <= failed["estimates"] <= 10
    assert (folder / "events.h5").stat().st_size > 100_000


def test_an_envelope_leaves_out_a_method_that_fails(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    few = ("--speeds", "2000", "--noises", "0.5", "--seeds", "1", "--only", "contrast")
    methods = ("--method", NOISY, "--method", FAILS)
    done = flybench("envelope", *few, *methods, "--jobs", "2", "--out", str(folder))
    assert done.returncode == 1, done.stderr
    assert f"flybench: {REASON}" in done.stderr
    assert WORDS not in done.stdout
    summary = json.loads((folder / "summary.json").read_text())
    assert list(summary["holds"]) == [NOISY]
    assert summary["failed"][FAILS].startswith(REASON)
