"""Processes of this machine."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from scenarios.errors import ScenarioError
from scenarios.pipeline.parallel import run_here

ROOT = Path(__file__).parents[2]
TWO = """
import time
from scenarios.pipeline.parallel import run_here
task = "__import__('time').sleep(0.5) or __import__('os').getpid()"
print(*(pid for _, pid in run_here(eval, [task] * 4, jobs=2)), flush=True)
time.sleep(600)
"""


def is_alive(pid: int) -> bool:
    status = Path(f"/proc/{pid}/stat")
    try:
        return status.read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc").exists(), reason="there is no /proc to look into")
def test_processes_end_with_the_one_that_started_them() -> None:
    main = subprocess.Popen([sys.executable, "-c", TWO], cwd=ROOT, stdout=subprocess.PIPE)
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


def test_results_come_with_the_numbers_of_their_tasks() -> None:
    assert sorted(run_here(abs, [-3, -1, -2], jobs=1)) == [(0, 3), (1, 1), (2, 2)]
    assert list(run_here(abs, [], jobs=1)) == []


def test_a_process_that_ends_is_told() -> None:
    with pytest.raises(ScenarioError, match=r"ended from outside.*fewer --jobs"):
        list(run_here(os._exit, [1, 1], jobs=2))


@pytest.mark.parametrize("jobs", [0, -2])
def test_no_number_of_processes_is_refused(jobs: int) -> None:
    with pytest.raises(ScenarioError, match=f"jobs is {jobs}; allowed is 1 or more, or -1"):
        list(run_here(abs, [1], jobs=jobs))
