"""Run and score points that share a rendered sequence."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from socket import gethostname
from typing import Any

import cv2
import numba

from flybench.memory import MemoryBudgetError
from scenarios.errors import ScenarioError, describe
from scenarios.options.cache import CacheOptions
from scenarios.pipeline.repeats import RunResult, run_side_by_side
from scenarios.pipeline.run_config import RunConfig, flatten
from scenarios.pipeline.running import make_crossing
from scenarios.pipeline.scoring import TargetTrack, score_estimates
from scenarios.pipeline.summary import truth_summary
from scenarios.sweep.point_key import code_digest
from sim import Crossing, RendererError
from sim.render.kept_renderer import keep_renderer

MAX_TASK_POINTS = 8
"""Points per task: eight flies with a DAVIS346 take 0.1 GB, beside 0.6 GB for the renderer."""
_TASK_LOCK = threading.Lock()

Results = Mapping[str, Any]
"""Results of a point, by dotted names as in a run's summary."""


@dataclass(frozen=True)
class Task:
    """Points that share a rendered sequence.

    Attributes:
        configs: configuration of each point.
        cache: cache for rendered luminance.
        code: `code_digest` of the process that makes the task.
        use_all_cores: True if no other task runs at the same time.
    """

    configs: tuple[RunConfig, ...]
    cache: CacheOptions = field(default_factory=CacheOptions)
    code: str = ""
    use_all_cores: bool = False


@dataclass(frozen=True)
class Failure:
    """The reason why a point has no result."""

    reason: str


def group_by_sequence(configs: Iterable[RunConfig]) -> list[list[RunConfig]]:
    """Return runs in groups that share a rendered sequence."""
    groups: dict[tuple[Any, ...], list[RunConfig]] = {}
    for c in configs:
        groups.setdefault(
            (c.crossing, c.sensor.width, c.sensor.height, c.sensor.focal_length_px), []
        ).append(c)
    return list(groups.values())


def make_tasks(
    configs: Iterable[RunConfig], cache: CacheOptions, *, use_all_cores: bool = False
) -> list[Task]:
    """Return tasks for all points; the first task of every rendered sequence comes first."""
    code = code_digest()
    tasks = [
        (start, Task(tuple(group[start : start + MAX_TASK_POINTS]), cache, code, use_all_cores))
        for group in group_by_sequence(configs)
        for start in range(0, len(group), MAX_TASK_POINTS)
    ]
    return [task for _, task in sorted(tasks, key=lambda numbered: numbered[0])]


def measure_task(task: Task) -> list[Results | Failure]:
    """Render the sequence of a task, or load it from the cache, and run and score every point.

    If the task fails, its points are run one by one, so that only the faulty ones fail.

    Returns:
        The results, or the failure, of each point.

    Raises:
        ScenarioError: this process runs other code than the process that made the task.
        RendererError: this machine cannot render.
    """
    if task.code != code_digest():
        raise ScenarioError(
            f"A worker on {gethostname()} runs another version of flybench or of a library, or "
            "edited files. Every worker needs the same code. Install it there and start again."
        )
    with _TASK_LOCK:  # a worker may have several threads, but can render only one sequence at once
        if not task.use_all_cores:
            pin_threads()
        keep_renderer()  # the next task may have the same model
        try:
            return list(_run_and_score(task.configs, task.cache))
        except RendererError:
            raise
        except Exception as error:
            if len(task.configs) == 1:
                refused = isinstance(error, MemoryBudgetError)
                return [Failure(str(error) if refused else describe(error))]
    return [
        result
        for config in task.configs
        for result in measure_task(replace(task, configs=(config,)))
    ]


def pin_threads() -> None:
    """Use one thread in this process, since other tasks use the other cores."""
    os.environ.setdefault("LP_NUM_THREADS", "1")  # read when the renderer starts
    cv2.setNumThreads(1)
    numba.set_num_threads(1)


def _run_and_score(
    configs: Sequence[RunConfig], cache: CacheOptions
) -> Iterable[Results | Failure]:
    crossing = make_crossing(configs[0], cache.open())
    runs, track = run_side_by_side(configs, crossing.samples())
    return (
        Failure(str(run.feed.failure))
        if run.feed.failure
        else _results(config, crossing, run, track)
        for config, run in zip(configs, runs, strict=True)
    )


def _results(config: RunConfig, crossing: Crossing, run: RunResult, track: TargetTrack) -> Results:
    direction, in_view_us = config.crossing.direction, track.in_view_us
    return dict(
        flatten(
            {
                "truth": truth_summary(config, crossing, in_view_us),
                "events": run.tally.summary(),
                "detector": score_estimates(run.estimates, direction, in_view_us, track),
            }
        )
    )
