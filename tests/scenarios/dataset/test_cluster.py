"""A dataset on a Dask cluster on this machine, with a worker that is lost."""

from contextlib import ExitStack
from functools import partial
from pathlib import Path

from scenarios.dataset.plan import read_plan
from scenarios.dataset.run import run_dataset
from scenarios.pipeline.cluster import run_on_cluster
from tests.scenarios.dataset.test_run import contents
from tests.scenarios.dataset.tiny import (
    QUICK,
    finished,
    make_quickly,
    quick_make,
    write_spec,
)
from tests.scenarios.sweep.quick_sweep import start
from tests.scenarios.sweep.test_cluster import running_scheduler, running_worker, wait_until


def make_on_cluster(spec: Path, folder: Path, address: str) -> None:
    run = partial(run_on_cluster, address=address)
    run_dataset(read_plan(spec), folder, run, make=quick_make)


def test_a_killed_worker_loses_no_sequence(tmp_path: Path) -> None:
    spec = write_spec(tmp_path / "quick.toml", QUICK.replace("train = 9", "train = 40"))
    with ExitStack() as stack:
        address, _ = stack.enter_context(running_scheduler(tmp_path))
        workers = [stack.enter_context(running_worker(tmp_path, address, n)) for n in range(2)]
        process = start(make_on_cluster, spec, tmp_path / "out", address)
        wait_until(lambda: finished(tmp_path / "out") >= 10 or not process.is_alive())
        workers[0].kill()
        at_kill = finished(tmp_path / "out")
        process.join(timeout=120)
    assert at_kill < 43
    assert process.exitcode == 0
    make_quickly(spec, tmp_path / "reference")
    assert contents(tmp_path / "out") == contents(tmp_path / "reference")
