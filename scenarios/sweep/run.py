"""A sweep from its points to its table: what is finished is kept, what is not is measured."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from scenarios.options.cache import CacheOptions
from scenarios.output.atomic_folder import GENERATOR, SUMMARY
from scenarios.pipeline.summary import versions
from scenarios.sweep.code import code_digest, point_key
from scenarios.sweep.folder import (
    COPY,
    CSV,
    JOURNAL,
    LOCK,
    PARQUET,
    drop_results,
    sweep_folder,
    whole_file,
)
from scenarios.sweep.journal import Journal
from scenarios.sweep.measure import Failure, Results, Task, make_tasks, measure
from scenarios.sweep.plan import Plan, Point
from scenarios.sweep.table import Row, rows, write_csv, write_parquet

Measure = Callable[[Task], list[Results | Failure]]
Progress = Callable[[int, int], None]
"""Called with the number of points that need no more work, and of all."""


class Runner(Protocol):
    """What does tasks, here or elsewhere, and gives their numbers and results as they come."""

    def __call__(
        self, function: Measure, tasks: Sequence[Task], /
    ) -> Iterator[tuple[int, list[Results | Failure]]]:
        """Do them."""
        ...


@dataclass(frozen=True)
class Done:
    """How a sweep ended.

    Attributes:
        table: a row a point, in the order of the points; empty where a point failed.
        failed: points that did, and why.
        found: how many points were finished before.
        left_out: how many finished points of the folder are none of this sweep's.
    """

    table: list[Row]
    failed: list[tuple[Point, str]]
    found: int
    left_out: int


def finished(folder: Path, points: Sequence[Point]) -> int:
    """How many of the points a folder holds already; nothing is written."""
    if not (folder / JOURNAL).is_file():
        return 0
    known = Journal.read(folder / JOURNAL)
    return sum(point_key(point.config) in known for point in points)


def run_sweep(
    plan: Plan,
    folder: Path,
    run: Runner,
    cache: CacheOptions | None = None,
    *,
    alone: bool = False,
    measure: Measure = measure,
    progress: Progress = lambda _done, _all: None,
) -> Done:
    """Measure the points that the folder does not hold yet, and write the table of all.

    The results depend neither on the runner nor on how often the sweep was begun.

    Args:
        plan: the points, and the file's text, which is copied.
        folder: where to; made, or taken up again.
        run: does the tasks.
        cache: where rendered light is kept; None: the user's folder.
        alone: whether tasks run one after the other, each with the whole machine.
        measure: does one task.
        progress: told at the start, and when points are finished.

    Raises:
        OutputError: the folder is somebody else's, is being written by another process, or
            cannot be written.
    """
    keys = [point_key(point.config) for point in plan.points]
    configs = {key: point.config for key, point in zip(keys, plan.points, strict=True)}
    with sweep_folder(folder), Journal(folder / JOURNAL) as journal:
        drop_results(folder)
        with whole_file(folder / COPY) as part:
            part.write_text(plan.text, encoding="utf-8")
        missing = {c: key for key, c in configs.items() if key not in journal.done}
        found, left_out = len(configs) - len(missing), len(journal.done.keys() - configs.keys())
        done = found
        progress(done, len(configs))
        tasks = make_tasks(missing, cache or CacheOptions(), alone=alone)
        reasons: dict[str, str] = {}
        for n, results in run(measure, tasks) if tasks else ():
            of_task = [missing[config] for config in tasks[n].configs]
            reasons |= _keep(journal, dict(zip(of_task, results, strict=True)))
            done += len(results)
            progress(done, len(configs))
        if reasons:
            named = zip(plan.points, keys, strict=True)
            return Done([], [(p, reasons[k]) for p, k in named if k in reasons], found, left_out)
        table = rows(plan.points, [journal.done[key] for key in keys])
        _write(folder, table, plan.points)
        return Done(table, [], found, left_out)


def _keep(journal: Journal, results: Mapping[str, Results | Failure]) -> dict[str, str]:
    """Write what was found; returns the reasons of what failed."""
    journal.add((key, r) for key, r in results.items() if not isinstance(r, Failure))
    return {key: r.reason for key, r in results.items() if isinstance(r, Failure)}


def _write(folder: Path, table: Sequence[Row], points: Sequence[Point]) -> None:
    """Write the tables, and then the summary: where it is, all is."""
    with whole_file(folder / CSV) as part:
        write_csv(part, table)
    with whole_file(folder / PARQUET) as part:
        write_parquet(part, table)
    said = {
        "generator": GENERATOR,
        "command": "sweep",
        "points": len(points),
        "varied": list(dict.fromkeys(name for point in points for name in point.varied)),
        "versions": versions(),
        "code": code_digest(),
        "files": sorted([COPY, CSV, JOURNAL, LOCK, PARQUET, SUMMARY]),
    }
    with whole_file(folder / SUMMARY) as part:
        part.write_text(json.dumps(said, indent=2) + "\n", encoding="utf-8")
