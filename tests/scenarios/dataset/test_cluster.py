"""A dataset on a Dask cluster on this machine, with a worker that is lost."""

from contextlib import ExitStack
from functools import partial
from pathlib import Path

import pytest

from scenarios.dataset.plan import read_plan
from scenarios.dataset.run import run_dataset
from scenarios.errors import ScenarioError
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


def refused_on_cluster(spec: Path, folder: Path, address: str, message: Path) -> None:
    """Make a dataset, and write the error that it ends with to a file."""
    run = partial(run_on_cluster, address=address)
    with pytest.raises(ScenarioError) as caught:
        run_dataset(read_plan(spec), folder, run)
    message.write_text(str(caught.value))


HIDDEN = """
from pathlib import Path

if "is_file" not in globals():  # a worker loads this twice
    is_file = Path.is_file
    Path.is_file = lambda path: "unseen" not in path.parts and is_file(path)
"""
"""Module that a worker loads, so that it does not see what is in a folder "unseen"."""


def test_a_worker_that_does_not_see_the_folder_is_named(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    spec, message = write_spec(tmp_path / "quick.toml", QUICK), tmp_path / "message.txt"
    (tmp_path / "hidden.py").write_text(HIDDEN)
    with ExitStack() as stack:
        address, _ = stack.enter_context(running_scheduler(tmp_path))
        for n in range(2):
            preload = "--preload", str(tmp_path / "hidden.py")
            stack.enter_context(running_worker(tmp_path, address, n, *preload))
        process = start(refused_on_cluster, spec, tmp_path / "unseen", address, message)
        process.join(timeout=120)
        hangs = process.is_alive()
        process.kill()
    assert not hangs
    assert process.exitcode == 0
    text = message.read_text()
    assert "\n" not in text
    assert f"does not see the folder {tmp_path / 'unseen'} of this dataset. Every worker" in text
    assert finished(tmp_path / "unseen") == 0
    assert "Traceback" not in capfd.readouterr().err


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
