"""A pool of threads that share the work of a step and wait between steps without using CPU time."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from queue import SimpleQueue
from threading import Thread
from typing import Any, TypeVar

Result = TypeVar("Result")
_Job = tuple[Callable[[int], Any], int]
_Outcome = tuple[Any, BaseException | None]


def _serve(jobs: SimpleQueue[_Job | None], outcomes: SimpleQueue[_Outcome]) -> None:
    """Run jobs until None arrives; exceptions go to the caller of `ThreadPool.run`."""
    while (job := jobs.get()) is not None:
        work, part = job
        try:
            outcomes.put((work(part), None))
        except BaseException as error:
            outcomes.put((None, error))
        del job, work


class ThreadPool:
    """A fixed number of threads, including the caller's, each of which runs one part of a job.

    The other threads end when nothing refers to the pool any more.

    Args:
        size: number of threads, at least 1.
    """

    def __init__(self, size: int):
        self._lanes: list[tuple[SimpleQueue[_Job | None], SimpleQueue[_Outcome]]] = []
        for _ in range(size - 1):
            lane: tuple[SimpleQueue[_Job | None], SimpleQueue[_Outcome]]
            lane = SimpleQueue(), SimpleQueue()
            Thread(target=_serve, args=lane, daemon=True).start()
            weakref.finalize(self, lane[0].put, None)
            self._lanes.append(lane)

    def run(self, work: Callable[[int], Result]) -> list[Result]:
        """Call `work` with the number of each part, from 0, and return the results in that order.

        Raises:
            Exception: the exception that a part raised, once all parts are done.
        """
        for part, (jobs, _) in enumerate(self._lanes, start=1):
            jobs.put((work, part))
        results: list[Any] = []
        failure: BaseException | None = None
        try:
            results.append(work(0))
        except BaseException as error:
            failure = error
        for _, outcomes in self._lanes:
            result, raised = outcomes.get()
            results.append(result)
            failure = failure or raised
        if failure is not None:
            raise failure
        return results
