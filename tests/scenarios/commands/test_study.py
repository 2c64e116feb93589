import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest

from scenarios.commands.study import Study
from scenarios.errors import ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.output.terminal import execute
from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY
from scenarios.study.rows import COLUMNS, study_rows
from scenarios.study.runner import run_sequences

TINY = Study(
    lighting="day",
    omegas=(2.42,),
    methods=(FLY, FRAME_FLY, CONTRAST),
    seeds=2,
    step_px=8.0,
    supersample=1,
    jobs=1,
    moving_backgrounds=False,
    second_sensor=False,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("study") / "out"
    cache = CacheOptions(cache=out.parent / "cache")
    assert replace(TINY, out=out, cache=cache).execute() == 0
    return out


def test_the_folder_has_report_table_figures_and_recordings(folder: Path) -> None:
    assert {path.name for path in folder.iterdir()} == {
        "figures",
        "recordings",
        "report.html",
        "results.csv",
        "summary.json",
    }
    assert (folder / "recordings" / "day_2.42.rrd").read_bytes().startswith(b"RRF2")
    assert {path.suffix for path in (folder / "figures").iterdir()} == {".svg", ".png"}
    with (folder / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == COLUMNS
    methods = [FLY, FRAME_FLY, CONTRAST]
    assert [(r["seed"], r["method"]) for r in rows] == [(s, m) for s in "01" for m in methods]
    assert {r["verdict"] for r in rows if r["method"] != FRAME_FLY} == {"right"}
    assert all(float(r["cpu_s"]) > 0 for r in rows)


def test_the_summary_has_parameters_and_results(folder: Path) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["command"] == "study"
    assert summary["parameters"]["omegas"] == [2.42]
    found = summary["statistics"][FLY]["day"]["accuracy_after_100ms"]
    assert found["number"] == 2
    assert found["low"] <= found["mean"] <= found["high"] <= 1.0
    holds = {claim["statement"]: claim["holds"] for claim in summary["claims"]}
    assert holds["the event-driven fly finds the correct direction in every sequence"] == "holds"
    assert "not tested" in holds.values()


def test_the_results_from_cached_luminance_are_equal(folder: Path) -> None:
    cache = folder.parent / "cache"
    kept = {path.name: path.stat().st_ino for path in cache.glob("*.light")}
    tasks = replace(TINY, cache=CacheOptions(cache=cache)).tasks()
    again = study_rows(run_sequences(tasks, jobs=1))
    assert kept == {path.name: path.stat().st_ino for path in cache.glob("*.light")} != {}
    with (folder / "results.csv").open(newline="") as file:
        first = list(csv.DictReader(file))
    for row, before in zip(again, first, strict=True):
        for name in set(COLUMNS) - {"cpu_s", "ms_per_estimate", "ns_per_event"}:
            assert before[name] == ("" if row[name] is None else str(row[name]))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"seeds": 0}, "--seeds is 0. Allowed is a whole number from 1 to 100"),
        ({"methods": ("bee",)}, "'bee'"),
        ({"methods": (FLY, FLY)}, "--methods is fly fly. Allowed is each value once"),
        ({"methods": ()}, "--methods is empty"),
        ({"omegas": (0.0,)}, "omega_rad_s"),
        ({"omegas": (1.61, 1.61)}, "Allowed is each value once"),
        ({"contrast_hop_ms": 30.0}, "Allowed is a multiple of hop_us"),
        ({"jobs": 0}, "jobs is 0"),
    ],
)
def test_bad_arguments_are_refused_before_rendering(
    changes: dict[str, object],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert execute(replace(TINY, out=tmp_path / "out", **changes)) == 2  # type: ignore[arg-type]
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_folder_not_written_by_flybench_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(ScenarioError, match="were not written by flybench"):
        replace(TINY, out=tmp_path).execute()
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_the_report_has_the_command_that_repeats_the_study() -> None:
    assert Study()._command() == "flybench study"
    assert replace(TINY, recordings=False)._command() == (
        "flybench study --lighting day --omegas 2.42 --methods fly frame-fly "
        "contrast-maximisation --seeds 2 --no-recordings --no-moving-backgrounds "
        "--no-second-sensor --step-px 8.0 --supersample 1"
    )
