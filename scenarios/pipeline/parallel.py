"""Run many tasks in parallel, in processes on this machine."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import TypeVar

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from scenarios.errors import ScenarioError

ONE_PER_CORE = -1
T = TypeVar("T")
R = TypeVar("R")


def check_jobs(jobs: int) -> None:
    """Check a number of processes.

    Raises:
        ScenarioError: the number is out of range.
    """
    if jobs != ONE_PER_CORE and jobs < 1:
        raise ScenarioError(
            f"jobs is {jobs}. Allowed is 1 or more, or -1 for one process per core. The default "
            "is -1."
        )


def run_locally(
    function: Callable[[T], R], tasks: Sequence[T], *, jobs: int
) -> Iterator[tuple[int, R]]:
    """Run tasks in processes of one thread each, and yield results as they finish.

    Args:
        function: function of one task; both are pickled and sent to another process.
        tasks: the tasks; there may be none.
        jobs: number of processes; −1: one per core.

    Yields:
        The index of a task, and its result.

    Raises:
        ScenarioError: the number of processes is out of range, or a process was killed.
    """
    check_jobs(jobs)
    parent = os.getpid()
    numbered = (delayed(_numbered)(parent, n, function, task) for n, task in enumerate(tasks))
    with parallel_config(backend="loky", n_jobs=jobs, inner_max_num_threads=1):
        results: Iterator[tuple[int, R]] = Parallel(return_as="generator_unordered", batch_size=1)(
            numbered
        )
        try:
            yield from results
        except TerminatedWorkerError as error:
            raise ScenarioError(
                "A worker process was killed, probably because memory ran out. Start again with "
                "fewer --jobs."
            ) from error


def _numbered(parent: int, n: int, function: Callable[[T], R], task: T) -> tuple[int, R]:
    if os.getpid() != parent:
        _end_with(parent)
    return n, function(task)


@cache
def _end_with(parent: int) -> None:
    """End this process when its parent ends.

    If the parent is killed, its workers would otherwise stay idle for minutes.
    """

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
