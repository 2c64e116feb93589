"""Run many tasks in parallel: in processes on this machine, or on a Dask cluster."""

from __future__ import annotations

import os
import pickle
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, TypeVar

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from scenarios.errors import ScenarioError

ONE_PER_CORE = -1
_TIMEOUT_S = 10
"""Longest wait for a scheduler, and for its first worker (assumed)."""
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


def run_on_cluster(
    function: Callable[[T], R], tasks: Sequence[T], *, address: str
) -> Iterator[tuple[int, R]]:
    """Run tasks on a Dask cluster. If a worker is lost, another one runs its tasks.

    Args:
        function: function of one task, importable on every worker.
        tasks: the tasks; there may be none.
        address: address of the scheduler, such as "tcp://127.0.0.1:8786".

    Yields:
        The index of a task, and its result, as tasks finish.

    Raises:
        ScenarioError: the library distributed is not installed, no scheduler answers, there is no
            worker, or several workers died while they ran the same task.
    """
    distributed = _distributed()
    with _client(distributed, address) as client:
        work = [pickle.dumps((function, task)) for task in tasks]
        futures = client.map(_run_pickled, work, pure=False)
        number = {future.key: n for n, future in enumerate(futures)}
        done = distributed.as_completed(
            futures, loop=client.loop, with_results=True, raise_errors=False
        )
        for future, result in done:
            if future.status != "finished":
                raise _cluster_error(distributed, address, result[1])
            yield number[future.key], result
            future.release()


def _run_pickled(work: bytes) -> Any:
    """Unpickle and run a task, so that a failed import is an error of the task, not the worker."""
    function, task = pickle.loads(work)
    return function(task)


def _distributed() -> Any:
    try:
        import distributed
    except ModuleNotFoundError as error:
        raise ScenarioError(
            f"A Dask cluster needs {error.name}, which is not installed. Install it with: "
            f"{sys.executable} -m pip install distributed"
        ) from error
    return distributed


def _client(distributed: Any, address: str) -> Any:
    try:
        client = distributed.Client(address, timeout=_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ScenarioError(
            f"No Dask scheduler answers at {address} ({error}). Allowed is the address that "
            "`dask scheduler` prints, such as tcp://127.0.0.1:8786. Start a scheduler first."
        ) from error
    try:
        client.wait_for_workers(1, timeout=_TIMEOUT_S)
    except TimeoutError as error:
        client.close()
        raise ScenarioError(
            f"The Dask scheduler at {address} has no worker. At least one is needed. Start workers "
            f"on each machine with: dask worker {address} --nthreads 1 --nworkers auto"
        ) from error
    return client


def _cluster_error(distributed: Any, address: str, error: BaseException) -> BaseException:
    """Return the error to raise for a failed task; faults of the cluster are explained."""
    if isinstance(error, distributed.KilledWorker):
        return ScenarioError(
            f"Several workers of the Dask cluster at {address} died while they ran the same task, "
            f"probably because memory ran out ({error}). Start again with fewer workers, or with "
            "more memory for each."
        )
    if isinstance(error, ModuleNotFoundError):
        return ScenarioError(
            f"A worker of the Dask cluster at {address} has no module {error.name}. Every worker "
            "needs the same flybench. Install it there."
        )
    return error
