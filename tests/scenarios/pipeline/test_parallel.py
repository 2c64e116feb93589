"""Tasks in processes of this machine."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from scenarios.errors import ScenarioError
from scenarios.pipeline.parallel import run_locally

ROOT = Path(__file__).parents[3]
TWO_WORKERS = """
import time
from scenarios.pipeline.parallel import run_locally
task = "__import__('time').sleep(0.5) or __import__('os').getpid()"
print(*(pid for _, pid in run_locally(eval, [task] * 4, jobs=2)), flush=True)
time.sleep(600)
"""


def is_alive(pid: int) -> bool:
    status = Path(f"/proc/{pid}/stat")
    try:
        return status.read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc").exists(), reason="needs /proc")
def test_workers_end_when_their_parent_is_killed() -> None:
    main = subprocess.Popen([sys.executable, "-c", TWO_WORKERS], cwd=ROOT, stdout=subprocess.PIPE)
    with main:
        assert main.stdout is not None
        workers = {int(pid) for pid in main.stdout.readline().split()}
        assert workers
        assert main.pid not in workers
        assert all(is_alive(pid) for pid in workers)
        main.kill()
    end_s = time.monotonic() + 30
    while any(is_alive(pid) for pid in workers):
        assert time.monotonic() < end_s
        time.sleep(0.05)


def test_each_result_has_the_index_of_its_task() -> None:
    assert sorted(run_locally(abs, [-3, -1, -2], jobs=1)) == [(0, 3), (1, 1), (2, 2)]
    assert list(run_locally(abs, [], jobs=1)) == []


def test_a_killed_worker_is_reported() -> None:
    with pytest.raises(ScenarioError, match=r"was killed.*fewer --jobs"):
        list(run_locally(os._exit, [1, 1], jobs=2))


@pytest.mark.parametrize("jobs", [0, -2])
def test_an_invalid_number_of_processes_is_refused(jobs: int) -> None:
    with pytest.raises(ScenarioError, match=rf"jobs is {jobs}\. Allowed is 1 or more, or -1"):
        list(run_locally(abs, [1], jobs=jobs))
