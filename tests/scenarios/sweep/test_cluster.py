"""Sweeps on a Dask cluster on this machine, with and without lost workers."""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from scenarios.errors import ScenarioError
from scenarios.pipeline.parallel import run_on_cluster
from scenarios.sweep.folder import CSV, PARQUET
from tests.scenarios.sweep.quick_sweep import (
    finished_points,
    start,
    sweep_in_process,
    sweep_on_cluster,
)

ROOT = Path(__file__).parents[3]
SWEEP = """
[grid]
crossing.omega_rad_s = [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6]
sensor.theta_on = [0.1, 0.2, 0.3, 0.4]
"""
POINTS = 48


@contextmanager
def running(*arguments: str, log: Path) -> Iterator[subprocess.Popen[bytes]]:
    with log.open("wb") as file:
        command = [sys.executable, "-m", *arguments]
        process = subprocess.Popen(command, cwd=ROOT, stdout=file, stderr=subprocess.STDOUT)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def wait_until(condition: Callable[[], bool], *, at_most_s: float = 60) -> None:
    end_s = time.monotonic() + at_most_s
    while not condition():
        assert time.monotonic() < end_s
        time.sleep(0.01)


def address_of(log: Path) -> str | None:
    """The address that the scheduler prints; None if it has not yet."""
    words = [word for word in log.read_text().split() if word.startswith("tcp://127.0.0.1:")]
    return words[0] if words else None


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    log = tmp_path_factory.mktemp("cluster") / "scheduler.log"
    scheduler = ("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0")
    with running(*scheduler, "--no-dashboard", log=log):
        wait_until(lambda: address_of(log) is not None)
        yield str(address_of(log))


def test_a_killed_worker_loses_no_point(scheduler: str, tmp_path: Path) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text(SWEEP)
    worker = ["distributed.cli.dask_worker", scheduler, "--nthreads", "1", "--no-nanny"]
    worker += ["--no-dashboard", "--local-directory", str(tmp_path)]
    with ExitStack() as stack:
        logs = [tmp_path / f"worker{n}.log" for n in range(2)]
        workers = [stack.enter_context(running(*worker, log=log)) for log in logs]
        for log in logs:
            wait_until(lambda log=log: "Starting established connection" in log.read_text())  # type: ignore[misc]
        process = start(sweep_on_cluster, file, tmp_path / "out", scheduler)
        third = POINTS // 3
        wait_until(lambda: finished_points(tmp_path / "out") >= third or not process.is_alive())
        workers[0].kill()
        finished_at_kill = finished_points(tmp_path / "out")
        process.join(timeout=60)
    assert finished_at_kill < POINTS * 2 // 3
    assert process.exitcode == 0
    assert finished_points(tmp_path / "out") == POINTS
    sweep_in_process(file, tmp_path / "reference")
    for name in (CSV, PARQUET):
        assert (tmp_path / "out" / name).read_bytes() == (
            tmp_path / "reference" / name
        ).read_bytes()


@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_a_missing_scheduler_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenarios.pipeline.parallel._TIMEOUT_S", 0.2)
    with pytest.raises(ScenarioError, match=r"No Dask scheduler answers at 127.0.0.1:9 .* Start"):
        list(run_on_cluster(abs, [1], address="127.0.0.1:9"))


@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_a_cluster_without_workers_is_reported(
    scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("scenarios.pipeline.parallel._TIMEOUT_S", 0.5)
    with pytest.raises(ScenarioError, match=r"has no worker\. .* dask worker tcp://127.0.0.1:"):
        list(run_on_cluster(abs, [1], address=scheduler))


def test_a_missing_library_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ScenarioError, match=r"Install it with: .* -m pip install distributed"):
        list(run_on_cluster(abs, [1], address="127.0.0.1:9"))
