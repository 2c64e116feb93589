"""Sweeps that are interrupted, resumed, changed or refused."""

import json
from functools import partial
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from scenarios.errors import OutputError
from scenarios.pipeline.parallel import run_locally
from scenarios.sweep.folder import CSV, FILES, JOURNAL, LOCK, PARQUET, sweep_folder
from scenarios.sweep.plan import read_plan
from scenarios.sweep.run import Measure, count_finished, run_sweep
from tests.scenarios.sweep.quick_sweep import (
    fail_for_seed_1,
    finished_points,
    kill_and_resume,
    must_not_run,
    quick_results,
    start,
    sweep_in_process,
)

SWEEP = """
seeds = 2
[grid]
crossing.omega_rad_s = [2.0, 0.5, 1.0, 4.0, 1.5, 2.5]
sensor.theta_on = [0.2, 0.1]
"""
HERE = partial(run_locally, jobs=1)


def write_sweep(path: Path, text: str = SWEEP) -> Path:
    path.write_text(text)
    return path


def tables(folder: Path) -> tuple[bytes, bytes]:
    return (folder / CSV).read_bytes(), (folder / PARQUET).read_bytes()


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A sweep file, and the folder of an uninterrupted sweep."""
    path = tmp_path_factory.mktemp("finished")
    file = write_sweep(path / "sweep.toml")
    sweep_in_process(file, path / "out")
    return file, path / "out"


def test_the_table_has_one_row_per_point_in_the_order_of_the_file(
    finished: tuple[Path, Path],
) -> None:
    folder = finished[1]
    assert {path.name for path in folder.iterdir()} == FILES
    assert (folder / "sweep.toml").read_text() == SWEEP
    table = pq.read_table(folder / PARQUET).to_pylist()
    got = [(r["crossing.omega_rad_s"], r["sensor.theta_on"], r["seed"]) for r in table]
    speeds = (2.0, 0.5, 1.0, 4.0, 1.5, 2.5)
    assert got == [(w, t, s) for w in speeds for t in (0.2, 0.1) for s in range(2)]
    assert len({row["events.count"] for row in table}) == 24
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["points"] == 24
    assert summary["varied"] == ["crossing.omega_rad_s", "sensor.theta_on", "seed"]
    assert set(summary["files"]) == FILES


def test_a_sweep_that_is_killed_and_resumed_gives_the_same_tables(
    finished: tuple[Path, Path], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    reached = kill_and_resume(
        lambda: start(sweep_in_process, finished[0], folder),
        lambda: finished_points(folder),
        seed=6,
        most=8,
    )
    assert any(0 < n < 24 for n in reached)
    assert reached == sorted(reached)
    assert finished_points(folder) == 24
    assert tables(folder) == tables(finished[1])


def test_a_point_with_an_incomplete_line_is_measured_again(
    finished: tuple[Path, Path], tmp_path: Path
) -> None:
    lines = (finished[1] / JOURNAL).read_bytes().splitlines(keepends=True)
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / LOCK).touch()
    (folder / JOURNAL).write_bytes(b"".join(lines[:20]) + lines[20][:-5])
    assert count_finished(folder, read_plan(finished[0]).points) == 20
    assert sweep_in_process(finished[0], folder).reused == 20
    assert tables(folder) == tables(finished[1])


def test_the_order_in_which_tasks_finish_changes_nothing(
    finished: tuple[Path, Path], tmp_path: Path
) -> None:
    run_sweep(
        read_plan(finished[0]),
        tmp_path / "out",
        partial(run_locally, jobs=2),
        measure=quick_results,
    )
    assert tables(tmp_path / "out") == tables(finished[1])

    def backwards(function: Measure, tasks: object) -> object:
        return reversed(list(run_locally(function, tasks, jobs=1)))  # type: ignore[arg-type]

    run_sweep(read_plan(finished[0]), tmp_path / "back", backwards, measure=quick_results)  # type: ignore[arg-type]
    assert tables(tmp_path / "back") == tables(finished[1])


def test_a_finished_point_is_not_measured_again(
    finished: tuple[Path, Path], tmp_path: Path
) -> None:
    reported: list[tuple[int, int]] = []
    plan = read_plan(finished[0])
    sweep_in_process(finished[0], tmp_path / "out")
    done = run_sweep(
        plan, tmp_path / "out", HERE, measure=must_not_run, progress=lambda *n: reported.append(n)
    )
    assert (done.reused, done.unused) == (24, 0)
    assert reported == [(24, 24)]
    assert tables(tmp_path / "out") == tables(finished[1])


def test_a_changed_file_reuses_the_points_that_it_shares(
    finished: tuple[Path, Path], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    sweep_in_process(finished[0], folder)
    other = write_sweep(
        tmp_path / "b.toml", SWEEP.replace("[2.0, 0.5, 1.0, 4.0, 1.5, 2.5]", "[1.0, 2.0, 3.0]")
    )
    done = sweep_in_process(other, folder)
    assert (done.reused, done.unused, len(done.table)) == (8, 16, 12)
    assert {row["crossing.omega_rad_s"] for row in done.table} == {1.0, 2.0, 3.0}
    again = sweep_in_process(finished[0], folder)
    assert (again.reused, again.unused) == (24, 4)
    assert tables(folder) == tables(finished[1])


def test_failed_points_are_named_and_the_others_are_kept(
    finished: tuple[Path, Path], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    sweep_in_process(write_sweep(tmp_path / "a.toml", "seeds = 1"), folder)
    done = run_sweep(read_plan(finished[0]), folder, HERE, measure=fail_for_seed_1)
    assert done.table == []
    assert {(p.config.seed, reason) for p, reason in done.failed} == {(1, "no luck")}
    assert len(done.failed) == 12
    assert not (folder / CSV).exists()  # that of the earlier sweep is removed
    assert sweep_in_process(finished[0], folder).reused == 12
    assert tables(folder) == tables(finished[1])


def test_a_second_process_in_one_folder_is_refused(
    finished: tuple[Path, Path], tmp_path: Path
) -> None:
    with (
        sweep_folder(tmp_path / "out"),
        pytest.raises(
            OutputError, match=r"Another process is running the sweep in .*\. Allowed is one"
        ),
    ):
        sweep_in_process(finished[0], tmp_path / "out")


@pytest.mark.parametrize("name", ["thesis.txt", "results.csv", "summary.json"])
def test_a_folder_of_something_else_is_refused_and_left_unchanged(
    name: str, finished: tuple[Path, Path], tmp_path: Path
) -> None:
    (tmp_path / name).write_text("mine")
    with pytest.raises(OutputError, match="were not written by flybench"):
        sweep_in_process(finished[0], tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [name]
