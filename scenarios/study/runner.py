"""All crossings of a study, side by side on every core."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from scenarios.pipeline.parallel import run_locally
from scenarios.study.one_sequence import SequenceTask, run_one
from scenarios.study.results import Sequence as Result
from scenarios.study.shared_progress import SharedProgress
from sim import Lighting

_LAVAPIPE_THREADS = "LP_NUM_THREADS"
"""Read by Mesa's renderer on the CPU, when it is first used."""
_REPLACED = "A worker stopped while some jobs were given"
"""What joblib says when it replaces a process that has grown, as a renderer makes it; no harm."""
Progress = Callable[[int, int], None]
"""Called with how much is done, and of how much."""


def run_all(
    tasks: Sequence[SequenceTask],
    *,
    jobs: int,
    progress: Progress = lambda _done, _all: None,
) -> list[Result]:
    """Do every task, in processes of one thread each; the dearest, those by night, first.

    Args:
        tasks: the crossings.
        jobs: how many processes; −1: one a core.
        progress: told how far all are together.

    Returns:
        Results in the order of the tasks, the same however many processes there are but for the
        times.

    Raises:
        ScenarioError: that is no number of processes, or one of them ended early.
        RendererError: this machine cannot render.
    """
    order = sorted(range(len(tasks)), key=lambda n: tasks[n].crossing.lighting is Lighting.DAY)
    results: dict[int, Result] = {}
    with tempfile.TemporaryDirectory() as scratch:
        shared = SharedProgress.begin(Path(scratch) / "progress", len(tasks))
        is_alone = jobs == 1 or len(tasks) == 1
        numbered = [_Numbered(n, tasks[n], shared, is_alone) for n in order]
        with shared.watched(progress), warnings.catch_warnings():
            warnings.filterwarnings("ignore", message=_REPLACED)
            for at, result in run_locally(_run, numbered, jobs=jobs):
                results[order[at]] = result
    return [results[n] for n in range(len(tasks))]


@dataclass(frozen=True)
class _Numbered:
    """A task that knows where to tell how far it is, and whether others run beside it."""

    number: int
    task: SequenceTask
    shared: SharedProgress
    is_alone: bool


def _run(numbered: _Numbered) -> Result:
    if not numbered.is_alone:  # other cores draw other sequences
        os.environ.setdefault(_LAVAPIPE_THREADS, "1")
    return run_one(numbered.task, partial(numbered.shared.tell, numbered.number))
