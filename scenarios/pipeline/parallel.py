"""Many tasks at once: in processes of this machine, or on a Dask cluster."""

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

ONE_A_CORE = -1
_ANSWER_S = 10
"""How long to wait for a scheduler, and for its first worker (assumed)."""
T = TypeVar("T")
R = TypeVar("R")


def check_jobs(jobs: int) -> None:
    """Refuse what is no number of processes.

    Raises:
        ScenarioError: it is none.
    """
    if jobs != ONE_A_CORE and jobs < 1:
        raise ScenarioError(
            f"jobs is {jobs}; allowed is 1 or more, or -1 for one a core; leave it out for that"
        )


def run_here(
    function: Callable[[T], R], tasks: Sequence[T], *, jobs: int
) -> Iterator[tuple[int, R]]:
    """Do tasks in processes of one thread each, and give results as they come.

    Args:
        function: of one task; it and its task go to another process.
        tasks: any number.
        jobs: how many processes; −1: one a core.

    Yields:
        The number of a task, and its result.

    Raises:
        ScenarioError: that is no number of processes, or one of them ended early.
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
                "one of the processes was ended from outside, as happens where memory runs out; "
                "start again with fewer --jobs"
            ) from error


def _numbered(parent: int, n: int, function: Callable[[T], R], task: T) -> tuple[int, R]:
    if os.getpid() != parent:
        _end_with(parent)
    return n, function(task)


@cache
def _end_with(parent: int) -> None:
    """End this process once its parent has, were it killed; else it would idle for minutes."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def run_on_cluster(
    function: Callable[[T], R], tasks: Sequence[T], *, address: str
) -> Iterator[tuple[int, R]]:
    """Do tasks on a Dask cluster; those of a worker that is lost are done by another.

    Args:
        function: of one task, importable on every worker.
        tasks: any number.
        address: of the scheduler, such as "tcp://127.0.0.1:8786".

    Yields:
        The number of a task, and its result, as they come.

    Raises:
        ScenarioError: distributed is not installed, no scheduler answers, there is no worker, or
            a task ended several workers.
    """
    distributed = _distributed()
    with _client(distributed, address) as client:
        work = [pickle.dumps((function, task)) for task in tasks]
        futures = client.map(_unpacked, work, pure=False)
        number = {future.key: n for n, future in enumerate(futures)}
        done = distributed.as_completed(
            futures, loop=client.loop, with_results=True, raise_errors=False
        )
        for future, result in done:
            if future.status != "finished":
                raise _lost(distributed, address, result[1])
            yield number[future.key], result
            future.release()


def _unpacked(work: bytes) -> Any:
    """Do a task; a failure to import what it needs is then the task's, not the worker's."""
    function, task = pickle.loads(work)
    return function(task)


def _distributed() -> Any:
    try:
        import distributed
    except ModuleNotFoundError as error:
        raise ScenarioError(
            f"a Dask cluster needs {error.name}, which is not installed; install it with: "
            f"{sys.executable} -m pip install distributed"
        ) from error
    return distributed


def _client(distributed: Any, address: str) -> Any:
    try:
        client = distributed.Client(address, timeout=_ANSWER_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ScenarioError(
            f"no Dask scheduler answers at {address} ({error}); allowed is the address that "
            "`dask scheduler` prints, such as tcp://127.0.0.1:8786; start one"
        ) from error
    try:
        client.wait_for_workers(1, timeout=_ANSWER_S)
    except TimeoutError as error:
        client.close()
        raise ScenarioError(
            f"the Dask scheduler at {address} has no worker; allowed is one or more; start one on "
            f"each machine with: dask worker {address} --nthreads 1 --nworkers auto"
        ) from error
    return client


def _lost(distributed: Any, address: str, error: BaseException) -> BaseException:
    """What became of a task without a result, told in a sentence where it was not its own fault."""
    if isinstance(error, distributed.KilledWorker):
        return ScenarioError(
            f"several workers of the Dask cluster at {address} ended while they did the same "
            f"task, as happens where memory runs out ({error}); start again with fewer or larger "
            "workers"
        )
    if isinstance(error, ModuleNotFoundError):
        return ScenarioError(
            f"a worker of the Dask cluster at {address} has no module {error.name}; allowed are "
            "workers on which the same flybench is installed; install it there"
        )
    return error
