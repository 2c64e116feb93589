"""Run many tasks in parallel on a Dask cluster."""

from __future__ import annotations

import logging
import pickle
import socket
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

from flybench.errors import FlybenchError
from flybench.memory import budget_gb, set_budget
from scenarios.errors import ScenarioError, describe

_TIMEOUT_S = 10
"""Longest wait for a scheduler, and for its first worker (assumed)."""
_NO_WORKER_S = 60.0
"""Longest time without a worker while tasks run (assumed: a worker that is replaced starts in a few
seconds)."""
_POLL_S = 0.1
_KEPT = "Finished points are kept."
T = TypeVar("T")
R = TypeVar("R")


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
        ScenarioError: the library distributed is not installed; no scheduler answers, or it was
            lost; there is no worker, or there was none for `_NO_WORKER_S`; several workers died
            while they ran the same task; or a task raised an error that is no `FlybenchError`.
        FlybenchError: raised by a task.
    """
    distributed = _distributed()
    with _quiet(), _client(distributed, address) as client:
        work = [pickle.dumps((function, task, budget_gb())) for task in tasks]
        futures = client.map(_run_pickled, work, pure=False)
        number = {future.key: n for n, future in enumerate(futures)}
        for future, packed in _completed(distributed, client, futures, address):
            if future.status == "error":
                raise _task_error(distributed, address, packed[1])
            if isinstance(packed, BaseException):
                raise _lost_error(address, packed)
            result = pickle.loads(packed)
            if isinstance(result, _Failed):
                raise result.error or _failed_error(address, result.text)
            yield number[future.key], result
            future.release()


def _completed(
    distributed: Any, client: Any, futures: Sequence[Any], address: str
) -> Iterator[tuple[Any, Any]]:
    """Yield futures and their results as they finish, while the cluster has workers."""
    done = distributed.as_completed(
        futures, loop=client.loop, with_results=True, raise_errors=False
    )
    seen_s = time.monotonic()
    while not done.is_empty():
        if done.has_ready():
            yield from done.next_batch(block=False)
            continue
        time.sleep(_POLL_S)
        try:
            has_workers = bool(client.nthreads())
        except Exception as error:
            raise _lost_error(address, error) from error
        if has_workers:
            seen_s = time.monotonic()
        elif time.monotonic() - seen_s > _NO_WORKER_S:
            raise ScenarioError(
                f"The Dask cluster at {address} has lost its workers, and there was none for "
                f"{_NO_WORKER_S:g} s. {_KEPT} Start workers with: dask worker {address} "
                "--nthreads 1 --nworkers auto. Then start the same command again."
            )


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep the client's tracebacks about lost connections from the terminal."""
    loggers = [logging.getLogger(name) for name in ("distributed.client", "tornado.application")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


@dataclass(frozen=True)
class _Failed:
    """An error of a task.

    Attributes:
        text: the error in one line.
        error: the error itself, if flybench raised it.
    """

    text: str
    error: FlybenchError | None


def _run_pickled(work: bytes) -> bytes:
    """Unpickle and run a task, and return its result or its error, pickled.

    An error is a result, because the client of distributed waits for ever for a task whose error
    or traceback cannot be pickled. A failed import is an error of the task, not of the worker.
    """
    try:
        function, task, budget = pickle.loads(work)
        set_budget(budget)
        return pickle.dumps(function(task))
    except ModuleNotFoundError:  # the client knows what to say
        raise
    except Exception as error:
        own = error if isinstance(error, FlybenchError) else None
        return pickle.dumps(_Failed(describe(error), own))


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
        _check_answer(*distributed.comm.get_address_host_port(address))
        client = distributed.Client(address, timeout=_TIMEOUT_S, set_as_default=False)
    except Exception as error:  # for some addresses distributed raises errors of other libraries
        raise ScenarioError(
            f"No Dask scheduler answers at {address!r} ({_one_line(error)}). Allowed is the "
            "address that `dask scheduler` prints, such as tcp://127.0.0.1:8786. Start a scheduler "
            "first."
        ) from error
    try:
        client.wait_for_workers(1, timeout=_TIMEOUT_S)
    except TimeoutError as error:
        client.close()
        raise ScenarioError(
            f"The Dask scheduler at {address} has no worker. At least one is needed. Start workers "
            f"on each machine with: dask worker {address} --nthreads 1 --nworkers auto"
        ) from error
    except Exception as error:
        client.close()
        raise _lost_error(address, error) from error
    return client


def _check_answer(host: str, port: int) -> None:
    """Check that a server speaks first, as a scheduler does; the client waits for ever otherwise.

    Raises:
        OSError: nothing listens at the address, or it sends nothing.
    """
    with socket.create_connection((host, port), timeout=_TIMEOUT_S) as connection:
        if not connection.recv(1):
            raise ConnectionResetError("the connection was closed")


def _task_error(distributed: Any, address: str, error: Exception) -> FlybenchError:
    """Return the error to raise for a task that failed; faults of the cluster are explained."""
    if isinstance(error, distributed.KilledWorker):
        return ScenarioError(
            f"Several workers of the Dask cluster at {address} died while they ran the same task, "
            f"probably because memory ran out ({_one_line(error)}). {_KEPT} Start again with fewer "
            "workers, or with more memory for each."
        )
    if isinstance(error, ModuleNotFoundError):
        return ScenarioError(
            f"A worker of the Dask cluster at {address} has no module {error.name}. Every worker "
            "needs the same flybench. Install it there."
        )
    return _failed_error(address, describe(error))


def _failed_error(address: str, text: str) -> ScenarioError:
    return ScenarioError(
        f"A task failed on the Dask cluster at {address}: {text}. {_KEPT} Check that scheduler and "
        "workers have the same flybench and the same libraries as this machine."
    )


def _lost_error(address: str, error: BaseException) -> ScenarioError:
    """Return the error to raise if the connection to the scheduler is lost."""
    return ScenarioError(
        f"The Dask scheduler at {address} was lost ({type(error).__name__}). {_KEPT} Start a "
        "scheduler, and then the same command again."
    )


def _one_line(error: BaseException) -> str:
    first_line, *_ = [*str(error).splitlines(), ""]
    return f"{type(error).__name__}: {first_line}"
