"""Runs all sequences of a study in parallel processes."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from scenarios.pipeline.parallel import run_locally
from scenarios.study.conditions import Background
from scenarios.study.finished import FinishedSequences
from scenarios.study.one_sequence import SequenceTask, evaluate_crossing
from scenarios.study.results import STILL, SequenceResult
from scenarios.study.shared_progress import SharedProgress
from sim import Lighting

_LAVAPIPE_THREADS = "LP_NUM_THREADS"
"""Environment variable that Mesa's CPU renderer reads when it is first used."""
_REPLACED = "A worker stopped while some jobs were given"
"""Start of joblib's harmless warning when it replaces a process whose memory has grown, as it does
with a renderer."""
_BY_DAY_S = {
    STILL: 40.0,
    Background.ALL: 35.0,
    Background.SHAKE: 25.0,
    Background.WIND: 14.0,
    Background.VEHICLE: 13.0,
}
"""CPU time of a sequence by day, by background [s] (measured, rendering included)."""
_AT_NIGHT = 1.6
"""How many times as long it takes at night (measured)."""
Progress = Callable[[int, int], None]
"""Called with the amount of work done and the amount of all work."""


def run_sequences(
    tasks: Sequence[SequenceTask],
    *,
    jobs: int,
    finished: FinishedSequences | None = None,
    progress: Progress = lambda _done, _all: None,
) -> list[SequenceResult]:
    """Run every task that is not finished, in processes of one thread each.

    Those that take longest come first, so that no process waits long for the last one.

    Args:
        tasks: sequences to run.
        jobs: number of processes; −1: one for each core.
        finished: results of tasks that are finished; new ones are added. None: none are kept.
        progress: called with the progress of all tasks together.

    Returns:
        Results in the order of the tasks. They do not depend on the number of processes, except for
        the CPU times.

    Raises:
        ScenarioError: the number of processes is out of range, or a process ended early.
        RendererError: this machine cannot render.
    """
    found = {n: finished.load(task) for n, task in enumerate(tasks)} if finished else {}
    results = {n: result for n, result in found.items() if result is not None}
    missing = [n for n in range(len(tasks)) if n not in results]
    order = sorted(missing, key=lambda n: _estimated_s(tasks[n]), reverse=True)
    with tempfile.TemporaryDirectory() as scratch:
        shared = SharedProgress.create(Path(scratch) / "progress", len(tasks))
        is_alone = jobs == 1 or len(tasks) == 1
        numbered = [_NumberedTask(n, tasks[n], shared, is_alone) for n in order]
        with shared.forwarded_to(progress), warnings.catch_warnings():
            warnings.filterwarnings("ignore", message=_REPLACED)
            for at, result in run_locally(_run, numbered, jobs=jobs):
                results[order[at]] = result
                if finished is not None:
                    finished.store(tasks[order[at]], result)
    return [results[n] for n in range(len(tasks))]


def _estimated_s(task: SequenceTask) -> float:
    """Return about how long a task takes with the default sensors and methods [s of CPU]."""
    by_day_s = _BY_DAY_S.get(task.background, _BY_DAY_S[STILL])
    return by_day_s * (1.0 if task.crossing.lighting is Lighting.DAY else _AT_NIGHT)


@dataclass(frozen=True)
class _NumberedTask:
    """A task, its number in the shared progress, and whether it runs without others beside it."""

    number: int
    task: SequenceTask
    shared: SharedProgress
    is_alone: bool


def _run(numbered: _NumberedTask) -> SequenceResult:
    if not numbered.is_alone:  # the other cores render other sequences
        os.environ.setdefault(_LAVAPIPE_THREADS, "1")
    return evaluate_crossing(numbered.task, partial(numbered.shared.report, numbered.number))
