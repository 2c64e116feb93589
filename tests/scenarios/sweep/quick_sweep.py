"""Sweeps whose points take no time, for tests that interrupt them."""

import hashlib
import multiprocessing
import random
import time
from collections.abc import Callable
from functools import partial
from multiprocessing.context import ForkServerProcess
from pathlib import Path

from scenarios.pipeline.cluster import run_on_cluster
from scenarios.pipeline.parallel import run_locally
from scenarios.sweep.folder import JOURNAL
from scenarios.sweep.measure import Failure, Results, Task
from scenarios.sweep.plan import read_plan
from scenarios.sweep.run import SweepResult, run_sweep

POINT_S, SLOW_S = 0.02, 0.05


def quick_results(task: Task, point_s: float = POINT_S) -> list[Results | Failure]:
    """Return made-up results that depend on the whole configuration and nothing else."""
    results: list[Results | Failure] = []
    for config in task.configs:
        time.sleep(point_s)
        digest = hashlib.sha256(repr(sorted(config.parameters().items())).encode()).digest()
        count, share = int.from_bytes(digest[:4], "big"), digest[4] / 255
        results.append({"events.count": count, "detector.accuracy": share})
    return results


def fail_for_seed_1(task: Task) -> list[Results | Failure]:
    """Return a failure for seed 1 and `quick_results` for all others."""
    pairs = zip(task.configs, quick_results(task), strict=True)
    return [Failure("no luck") if config.seed == 1 else result for config, result in pairs]


def must_not_run(task: Task) -> list[Results | Failure]:
    raise AssertionError("a point was measured")


def sweep_in_process(file: Path, folder: Path) -> SweepResult:
    """Run a sweep in this process, one point after another."""
    return run_sweep(read_plan(file), folder, partial(run_locally, jobs=1), measure=quick_results)


def sweep_on_cluster(file: Path, folder: Path, address: str) -> None:
    run = partial(run_on_cluster, address=address)
    run_sweep(read_plan(file), folder, run, measure=partial(quick_results, point_s=SLOW_S))


def start(target: Callable[..., object], *arguments: object) -> ForkServerProcess:
    """Call a function of this module in a new process."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([__name__])
    process = context.Process(target=target, args=arguments)
    process.start()
    return process


def kill_and_resume(
    begin: Callable[[], ForkServerProcess], finished: Callable[[], int], *, seed: int, most: int
) -> list[int]:
    """Start a process again and again, and kill it at random moments, until it ends by itself.

    Args:
        begin: starts the process.
        finished: returns what is finished so far.
        seed: seed of the moments.
        most: a process is killed before it has finished this much more.

    Returns:
        What was finished after each kill, beginning with 0.
    """
    moments, reached = random.Random(seed), [0]
    for _ in range(100):
        process = begin()
        due = reached[-1] + moments.randrange(most)
        while process.is_alive() and finished() < due:
            process.join(timeout=0.001)
        process.join(timeout=moments.uniform(0.0, 0.05))
        if process.exitcode is not None:
            break
        process.kill()
        process.join()
        reached.append(finished())
    assert process.exitcode == 0
    return reached


def finished_points(folder: Path) -> int:
    """Return the number of lines in the journal."""
    path = folder / JOURNAL
    return path.read_bytes().count(b"\n") if path.exists() else 0


class FailingDetector:
    """A user's detector that fails when it receives events."""

    def __init__(self, *, width: int, height: int) -> None:
        self.size = width, height

    def push(self, events: object) -> list[object]:  # noqa: ARG002
        raise RuntimeError("no nectar")

    def advance(self, t_us: int) -> list[object]:  # noqa: ARG002
        return []
