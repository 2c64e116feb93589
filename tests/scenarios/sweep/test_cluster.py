"""Sweeps on a Dask cluster on this machine, with and without lost workers."""

import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from scenarios.errors import ScenarioError
from scenarios.pipeline.cluster import run_on_cluster
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


@contextmanager
def running_scheduler(folder: Path) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """Run a scheduler; yield its address and its process."""
    log = folder / "scheduler.log"
    arguments = ("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0")
    with running(*arguments, "--no-dashboard", log=log) as process:
        wait_until(lambda: address_of(log) is not None)
        yield str(address_of(log)), process


@contextmanager
def running_worker(
    folder: Path, address: str, n: int = 0, *options: str
) -> Iterator[subprocess.Popen[bytes]]:
    """Run a worker with one thread that is not replaced when it is killed."""
    log = folder / f"worker{n}.log"
    arguments = ["distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny"]
    arguments += ["--no-dashboard", "--local-directory", str(folder), *options]
    with running(*arguments, log=log) as process:
        wait_until(lambda: "Starting established connection" in log.read_text())
        yield process


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with running_scheduler(tmp_path_factory.mktemp("cluster")) as (address, _):
        yield address


def test_a_killed_worker_loses_no_point(scheduler: str, tmp_path: Path) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text(SWEEP)
    with ExitStack() as stack:
        workers = [stack.enter_context(running_worker(tmp_path, scheduler, n)) for n in range(2)]
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
    monkeypatch.setattr("scenarios.pipeline.cluster._TIMEOUT_S", 0.2)
    with pytest.raises(ScenarioError, match=r"No Dask scheduler answers at '127.0.0.1:9' .* Start"):
        list(run_on_cluster(abs, [1], address="127.0.0.1:9"))


@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_a_cluster_without_workers_is_reported(
    scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("scenarios.pipeline.cluster._TIMEOUT_S", 0.5)
    with pytest.raises(ScenarioError, match=r"has no worker\. .* dask worker tcp://127.0.0.1:"):
        list(run_on_cluster(abs, [1], address=scheduler))


def test_a_missing_library_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ScenarioError, match=r"Install it with: .* -m pip install distributed"):
        list(run_on_cluster(abs, [1], address="127.0.0.1:9"))


@pytest.mark.parametrize("lost", ["scheduler", "worker"])
def test_a_lost_cluster_is_one_sentence_and_finished_points_are_kept(
    lost: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("scenarios.pipeline.cluster._NO_WORKER_S", 0.5)
    file, folder = tmp_path / "sweep.toml", tmp_path / "out"
    file.write_text(SWEEP)
    with ExitStack() as stack:
        address, scheduler = stack.enter_context(running_scheduler(tmp_path))
        worker = stack.enter_context(running_worker(tmp_path, address))
        killed = {"scheduler": scheduler, "worker": worker}[lost]

        def kill() -> None:
            wait_until(lambda: finished_points(folder) >= 3)
            killed.kill()

        killing = threading.Thread(target=kill)
        killing.start()
        with pytest.raises(ScenarioError) as raised:
            sweep_on_cluster(file, folder, address)
        killing.join()
    message = str(raised.value)
    assert f"The Dask {'cluster' if lost == 'worker' else 'scheduler'} at {address}" in message
    assert f"lost{' its workers' if lost == 'worker' else ''}" in message
    assert "Finished points are kept. Start" in message
    assert 3 <= finished_points(folder) < POINTS
    assert "Traceback" not in capfd.readouterr().err


def test_an_error_in_a_task_is_one_sentence(scheduler: str, tmp_path: Path) -> None:
    with (
        running_worker(tmp_path, scheduler),
        pytest.raises(
            ScenarioError,
            match=r"A task failed .* TypeError: object of type .int. has no len.* Check that",
        ),
    ):
        list(run_on_cluster(len, [1], address=scheduler))  # type: ignore[arg-type]


def without_end(_: int) -> int:
    """Fail with a traceback that cannot be pickled, as it is too deep."""
    return without_end(0)


def test_an_error_that_cannot_be_pickled_is_one_sentence_too(
    scheduler: str, tmp_path: Path
) -> None:
    with (
        running_worker(tmp_path, scheduler),
        pytest.raises(ScenarioError, match=r"A task failed .* RecursionError: maximum recursion"),
    ):
        list(run_on_cluster(without_end, [1], address=scheduler))


@pytest.mark.parametrize(
    "address", ["", "bee", "foo://a:1", "tls://127.0.0.1:9", "ucx://127.0.0.1:9", "127.0.0.1:99999"]
)
def test_an_address_that_is_none_of_a_scheduler_is_refused(address: str) -> None:
    with pytest.raises(
        ScenarioError, match=rf"No Dask scheduler answers at '{address}' .* Allowed"
    ):
        list(run_on_cluster(abs, [1], address=address))


def test_a_server_that_is_no_scheduler_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenarios.pipeline.cluster._TIMEOUT_S", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(ScenarioError, match=r"No Dask scheduler answers at .*timed out"):
            list(run_on_cluster(abs, [1], address=address))
