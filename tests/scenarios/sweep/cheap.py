"""A sweep whose points cost nothing, run in a process of its own that may be killed."""

import hashlib
import multiprocessing
import time
from collections.abc import Callable
from functools import partial
from multiprocessing.context import ForkServerProcess
from pathlib import Path

from scenarios.pipeline.parallel import run_here, run_on_cluster
from scenarios.sweep.folder import JOURNAL
from scenarios.sweep.measure import Failure, Results, Task
from scenarios.sweep.plan import read_plan
from scenarios.sweep.run import Done, run_sweep

POINT_S, SLOW_S = 0.02, 0.05


def cheap(task: Task, point_s: float = POINT_S) -> list[Results | Failure]:
    """Numbers that depend on the whole configuration, and on nothing else."""
    results: list[Results | Failure] = []
    for config in task.configs:
        time.sleep(point_s)
        digest = hashlib.sha256(repr(sorted(config.parameters().items())).encode()).digest()
        count, share = int.from_bytes(digest[:4], "big"), digest[4] / 255
        results.append({"events.count": count, "detector.accuracy": share})
    return results


def broken(task: Task) -> list[Results | Failure]:
    """Fails for the seed 1."""
    found = zip(task.configs, cheap(task), strict=True)
    return [Failure("no luck") if config.seed == 1 else result for config, result in found]


def refused(task: Task) -> list[Results | Failure]:
    raise AssertionError("nothing was to be measured")


def sweep_alone(file: Path, folder: Path) -> Done:
    """In this process, one point after the other."""
    return run_sweep(read_plan(file), folder, partial(run_here, jobs=1), measure=cheap)


def sweep_on_cluster(file: Path, folder: Path, address: str) -> None:
    run = partial(run_on_cluster, address=address)
    run_sweep(read_plan(file), folder, run, measure=partial(cheap, point_s=SLOW_S))


def start(target: Callable[..., object], *arguments: object) -> ForkServerProcess:
    """Call a function of this module in a process that starts at once."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([__name__])
    process = context.Process(target=target, args=arguments)
    process.start()
    return process


def finished_points(folder: Path) -> int:
    """Lines of the journal."""
    path = folder / JOURNAL
    return path.read_bytes().count(b"\n") if path.exists() else 0


class Bee:
    """A detector of one's own that fails when it is used."""

    def __init__(self, *, width: int, height: int) -> None:
        self.size = width, height

    def push(self, events: object) -> list[object]:  # noqa: ARG002
        raise RuntimeError("no nectar")

    def advance(self, t_us: int) -> list[object]:  # noqa: ARG002
        return []
