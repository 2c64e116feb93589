"""Some points that share their light: rendered once, shown to all of them, and judged."""

from __future__ import annotations

import os
import threading
import traceback
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from socket import gethostname
from typing import Any

import cv2
import numba

from scenarios.errors import ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.pipeline.repeats import Seen, run_side_by_side
from scenarios.pipeline.run_config import RunConfig, flat
from scenarios.pipeline.running import make_crossing
from scenarios.pipeline.scoring import Track, judge
from scenarios.pipeline.summary import truth_summary
from scenarios.sweep.code import code_digest
from sim import Crossing, RendererError

MOST_TOGETHER = 8
"""Points to a task: so many flies behind a DAVIS346 take 0.1 GB beside the 0.6 of a renderer."""
_ONE_AT_A_TIME = threading.Lock()

Results = Mapping[str, Any]
"""What was found for a point, by dotted names as in a run's summary."""


@dataclass(frozen=True)
class Task:
    """Points that share their light.

    Attributes:
        configs: one a point.
        light: where rendered light is kept.
        code: of the process that asks, see `code_digest`.
        alone: whether it may have the whole machine.
    """

    configs: tuple[RunConfig, ...]
    light: CacheOptions = field(default_factory=CacheOptions)
    code: str = ""
    alone: bool = False


@dataclass(frozen=True)
class Failure:
    """Why there is no result."""

    reason: str


def by_light(configs: Iterable[RunConfig]) -> list[list[RunConfig]]:
    """Runs in groups that share their light."""
    groups: dict[tuple[Any, ...], list[RunConfig]] = {}
    for c in configs:
        groups.setdefault(
            (c.crossing, c.sensor.width, c.sensor.height, c.sensor.focal_length_px), []
        ).append(c)
    return list(groups.values())


def make_tasks(
    configs: Iterable[RunConfig], light: CacheOptions, *, alone: bool = False
) -> list[Task]:
    """Cut points into tasks: first one for every light, then the further ones of each."""
    tasks = [
        (start, Task(tuple(own[start : start + MOST_TOGETHER]), light, code_digest(), alone))
        for own in by_light(configs)
        for start in range(0, len(own), MOST_TOGETHER)
    ]
    return [task for _, task in sorted(tasks, key=lambda numbered: numbered[0])]


def measure(task: Task) -> list[Results | Failure]:
    """Render the light of a task, or have it from the cache, and judge every point.

    Returns:
        Results by point; where something fails, for the points alone that it fails for.

    Raises:
        ScenarioError: this process runs other code than the one that asks.
        RendererError: this machine cannot render.
    """
    if task.code != code_digest():
        raise ScenarioError(
            f"a worker on {gethostname()} runs another version of flybench or of what it needs, "
            "or edited files; allowed is the same everywhere; install it there and start anew"
        )
    with _ONE_AT_A_TIME:  # of a worker with several threads, since one renders at a time
        if not task.alone:
            _pin_threads()
        try:
            return list(_measured(task.configs, task.light))
        except RendererError:
            raise
        except Exception as error:
            if len(task.configs) == 1:
                return [Failure(_told(error))]
    return [
        result
        for config in task.configs
        for result in measure(Task((config,), task.light, task.code, task.alone))
    ]


def _told(error: Exception) -> str:
    """An error in one line, with where it was raised."""
    *_, last = traceback.extract_tb(error.__traceback__)
    first, *_ = [*str(error).splitlines(), ""]
    return f"{type(error).__name__}: {first} ({Path(last.filename).name}, line {last.lineno})"


def _pin_threads() -> None:
    """One thread, since the other cores have points of their own."""
    os.environ.setdefault("LP_NUM_THREADS", "1")  # read when the renderer first starts
    cv2.setNumThreads(1)
    numba.set_num_threads(1)


def _measured(configs: Sequence[RunConfig], light: CacheOptions) -> Iterable[Results]:
    crossing = make_crossing(configs[0], light.open())
    seen, track = run_side_by_side(configs, crossing.samples())
    return (
        _results(config, crossing, one, track) for config, one in zip(configs, seen, strict=True)
    )


def _results(config: RunConfig, crossing: Crossing, seen: Seen, track: Track) -> Results:
    judged = judge(seen.estimates, config.crossing.direction, track.in_view_us, track)
    return dict(
        flat(
            {
                "truth": truth_summary(config, crossing, track.in_view_us),
                "events": seen.tally.summary(),
                "detector": judged,
            }
        )
    )
