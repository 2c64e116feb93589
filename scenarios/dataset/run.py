"""Make a dataset: the sequences that are not finished, and the files that describe the whole."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from socket import gethostname
from typing import Any, Protocol

from scenarios.dataset.describe import write_description
from scenarios.dataset.folder import (
    COPY,
    dataset_folder,
    drop_results,
    finished_sequences,
)
from scenarios.dataset.plan import DatasetPlan
from scenarios.dataset.sequence import Cost, file_digest, make_sequence
from scenarios.dataset.sequence_plan import SequencePlan, code_digest
from scenarios.dataset.size import estimated_bytes
from scenarios.errors import ScenarioError
from scenarios.sweep.folder import durable_file
from scenarios.sweep.measure import pin_threads

_TASK_LOCK = threading.Lock()
Progress = Callable[[int, int, int], None]
"""Called with the number of finished and of all sequences, and the size of the former [bytes]."""


@dataclass(frozen=True)
class Task:
    """One sequence to make.

    Attributes:
        sequence: the sequence.
        folder: folder of the dataset, as an absolute path.
        spec_digest: digest of the copy of the spec in the folder.
        code: `code_digest` of the process that makes the task.
        use_all_cores: True if no other task runs at the same time.
    """

    sequence: SequencePlan
    folder: Path
    spec_digest: str
    code: str
    use_all_cores: bool = False


Make = Callable[[Task], Cost]


class Runner(Protocol):
    """Function that runs tasks, here or on a cluster, and yields results as they finish."""

    def __call__(self, function: Make, tasks: Sequence[Task], /) -> Iterator[tuple[int, Cost]]:
        """Run the tasks, and yield the index and the result of each."""
        ...


@dataclass(frozen=True)
class DatasetResult:
    """What a run has made.

    Attributes:
        summaries: summary of every sequence, in the order of the plan.
        costs: CPU times of the sequences that were made now.
        size_bytes: size of all sequences [bytes].
    """

    summaries: Sequence[Mapping[str, Any]]
    costs: Sequence[Cost]
    size_bytes: int


def run_task(task: Task) -> Cost:
    """Make one sequence.

    Raises:
        ScenarioError: this process runs other code than the process that made the task, or does not
            see its folder.
        FlybenchError: the sequence cannot be made or written.
    """
    if task.code != code_digest():
        raise ScenarioError(
            f"A worker on {gethostname()} runs another version of flybench or of a library, or "
            "edited files. Every worker needs the same code. Install it there and start again."
        )
    copy = task.folder / COPY
    if not copy.is_file() or file_digest(copy) != task.spec_digest:
        raise ScenarioError(
            f"A worker on {gethostname()} does not see the folder {task.folder} of this dataset. "
            "Every worker writes its sequences there. Choose a folder of a shared file system that "
            "has the same path on all machines, with --out."
        )
    with _TASK_LOCK:  # a worker may have several threads, but can render only one sequence at once
        if not task.use_all_cores:
            pin_threads()
        return make_sequence(task.sequence, task.folder / task.sequence.name)


def needed_bytes(folder: Path, plan: DatasetPlan) -> int:
    """Return about how much the sequences need that are not finished in a folder [bytes]."""
    finished = finished_sequences(folder, plan.sequences)
    return sum(estimated_bytes(s) for s in plan.sequences if s.name not in finished)


def run_dataset(
    plan: DatasetPlan,
    folder: Path,
    run: Runner,
    *,
    use_all_cores: bool = False,
    make: Make = run_task,
    progress: Progress = lambda _done, _all, _bytes: None,
) -> DatasetResult:
    """Make the sequences that are not finished in a folder, and describe the whole.

    The files do not depend on the runner, or on how often the work was interrupted.

    Args:
        plan: the dataset.
        folder: output folder; it is created or resumed.
        run: function that runs the tasks.
        use_all_cores: True if tasks run one after another, each on all cores.
        make: function that runs one task.
        progress: function that is called at the start, and whenever a sequence is finished.

    Raises:
        OutputError: the folder holds other files, is in use by another process, or cannot be
            written to.
        FlybenchError: a sequence cannot be made; the finished ones are kept.
    """
    folder = folder.absolute()
    with dataset_folder(folder, plan, needed_bytes(folder, plan)):
        drop_results(folder, plan.spec.counts)
        with durable_file(folder / COPY) as part:
            part.write_text(plan.spec.text, encoding="utf-8")
        costs = _make_missing(plan, folder, run, make, progress, use_all_cores=use_all_cores)
        finished = finished_sequences(folder, plan.sequences)
        summaries = [finished[sequence.name] for sequence in plan.sequences]
        write_description(folder, plan, summaries)
        return DatasetResult(summaries, costs, sum(_size(folder, s) for s in plan.sequences))


def _make_missing(
    plan: DatasetPlan,
    folder: Path,
    run: Runner,
    make: Make,
    progress: Progress,
    *,
    use_all_cores: bool,
) -> list[Cost]:
    finished = finished_sequences(folder, plan.sequences)
    missing = [s for s in plan.sequences if s.name not in finished]
    size = sum(_size(folder, s) for s in plan.sequences if s.name in finished)
    total, done, costs = len(plan.sequences), len(finished), []
    progress(done, total, size)
    digest, code = file_digest(folder / COPY), code_digest()
    tasks = [Task(s, folder, digest, code, use_all_cores) for s in missing]
    for n, cost in run(make, tasks) if tasks else ():
        costs.append(cost)
        done, size = done + 1, size + _size(folder, missing[n])
        progress(done, total, size)
    return costs


def _size(folder: Path, sequence: SequencePlan) -> int:
    files = (folder / sequence.name).rglob("*")
    return sum(path.stat().st_size for path in files if path.is_file())
