"""The command `flybench sweep`."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import pytest

from scenarios.commands.sweep import Sweep
from scenarios.errors import OutputError, ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.sweep.parameters import parameter_types
from tests.scenarios.sweep.quick_sweep import sweep_in_process

FAILING = "tests.scenarios.sweep.quick_sweep:FailingDetector"
TINY = """
[fixed]
crossing.omega_rad_s = 3.0
crossing.step_px = 8
crossing.supersample = 1
crossing.lead_s = 0.05
sensor.width = 96
sensor.height = 64

[grid]
method = ["fly", "plane-fit"]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "tiny.toml"
    path.write_text(TINY)
    return path


def test_a_sweep_writes_its_table_and_can_be_repeated(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = [
        sys.executable,
        "-m",
        "scenarios.commands.sweep",
        str(file),
        "--out",
        "out",
        "--jobs",
        "1",
    ]
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=tmp_path, env=environment
    )
    assert done.returncode == 0, done.stderr
    assert "2 points, 0 finished before" in done.stdout
    before = (tmp_path / "out" / "results.csv").read_bytes()
    assert Sweep(file, out=tmp_path / "out").execute() == 0
    assert "2 points, 2 finished before" in capsys.readouterr().out
    assert (tmp_path / "out" / "results.csv").read_bytes() == before
    with (tmp_path / "out" / "results.csv").open(newline="") as table:
        fly, plane = list(csv.DictReader(table))
    assert (fly["method"], plane["method"]) == ("fly", "plane-fit")
    assert fly["detector.direction"] == "right" == fly["truth.direction"]
    assert (fly["fly.tau_us"], plane["fly.tau_us"]) == ("30000", "")
    assert fly["events.count"] == plane["events.count"] != "0"
    assert set(parameter_types()) - {"sensor.preset"} <= set(fly)


def test_a_dry_run_prints_points_and_writes_nothing(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert Sweep(file, out=tmp_path / "out", dry_run=True).execute() == 0
    printed = capsys.readouterr().out
    assert "plane-fit" in printed
    assert "2 points of 1 sequence; 0 finished" in printed
    assert [path.name for path in tmp_path.iterdir()] == ["tiny.toml"]
    sweep_in_process(file, tmp_path / "out")
    Sweep(file, out=tmp_path / "out", dry_run=True).execute()
    assert "2 finished" in capsys.readouterr().out


def test_all_parameters_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert Sweep(parameters=True).execute() == 0
    printed = capsys.readouterr().out
    assert all(f" {name} " in printed for name in parameter_types())
    assert 'one of "day", "dusk", "night"' in printed


def test_invalid_arguments_are_refused_before_anything_is_written(
    file: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    with pytest.raises(ScenarioError, match=r"No file is given\. Allowed is a TOML file"):
        Sweep(out=out).execute()
    with pytest.raises(ScenarioError, match=r"jobs is 0\. Allowed is 1 or more"):
        Sweep(file, out=out, jobs=0).execute()
    with pytest.raises(
        ScenarioError, match=r"--jobs is 2 and --dask is tcp://x\. Allowed is only one"
    ):
        Sweep(file, out=out, jobs=2, dask="tcp://x").execute()
    cache = CacheOptions(cache=tmp_path, no_cache=True)
    with pytest.raises(ScenarioError, match="--no-cache is given too"):
        Sweep(file, out=out, cache=cache).execute()
    with pytest.raises(OutputError, match="were not written by flybench"):
        Sweep(file, out=tmp_path).execute()
    assert [path.name for path in tmp_path.iterdir()] == ["tiny.toml"]


def test_a_failed_point_is_printed_and_sets_the_exit_status(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "failing.toml"
    file.write_text(TINY.replace('"fly", "plane-fit"', f'"{FAILING}"'))
    assert Sweep(file, out=tmp_path / "out", jobs=1).execute() == 1
    printed = capsys.readouterr().out
    assert f"failed: method = {FAILING}: {FAILING}: push raised an error after " in printed
    assert "RuntimeError: no nectar (quick_sweep.py, line" in printed
    assert "1 of 1 point failed, so no table is written" in printed
