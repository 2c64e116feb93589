"""Run a sweep: measure the points that are not finished, and write the table of all."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from scenarios.options.cache import CacheOptions
from scenarios.output.atomic_folder import GENERATOR, SUMMARY
from scenarios.output.versions import versions
from scenarios.sweep.folder import (
    COPY,
    CSV,
    JOURNAL,
    LOCK,
    PARQUET,
    drop_results,
    durable_file,
    sweep_folder,
)
from scenarios.sweep.journal import Journal
from scenarios.sweep.measure import Failure, Results, Task, make_tasks, measure_task
from scenarios.sweep.plan import Plan, Point
from scenarios.sweep.point_key import code_digest, point_key
from scenarios.sweep.table import Row, make_rows, write_csv, write_parquet
from sim.render.kept_renderer import kept_renderer

Measure = Callable[[Task], list[Results | Failure]]
Progress = Callable[[int, int], None]
"""Called with the number of finished points and the number of all points."""


class Runner(Protocol):
    """Function that runs tasks, here or on a cluster, and yields results as they finish."""

    def __call__(
        self, function: Measure, tasks: Sequence[Task], /
    ) -> Iterator[tuple[int, list[Results | Failure]]]:
        """Run the tasks, and yield the index and the result of each."""
        ...


@dataclass(frozen=True)
class SweepResult:
    """Result of a sweep.

    Attributes:
        table: one row per point, in the order of the points; empty if a point failed.
        failed: the failed points and the reasons.
        reused: number of points that were finished before.
        unused: number of finished points in the folder that do not belong to this sweep.
    """

    table: list[Row]
    failed: list[tuple[Point, str]]
    reused: int
    unused: int


def count_finished(folder: Path, points: Sequence[Point]) -> int:
    """Return how many of the points are finished in a folder, without writing to it."""
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
    use_all_cores: bool = False,
    measure: Measure = measure_task,
    progress: Progress = lambda _done, _all: None,
) -> SweepResult:
    """Measure the points that are not finished in a folder, and write the table of all points.

    The results do not depend on the runner, or on how often the sweep was interrupted.

    Args:
        plan: the points, and the text of the file, which is copied into the folder.
        folder: output folder; it is created or resumed.
        run: function that runs the tasks.
        cache: cache for rendered luminance; None: the default cache.
        use_all_cores: True if tasks run one after another, each on all cores.
        measure: function that runs one task.
        progress: function that is called at the start, and whenever points are finished.

    Raises:
        OutputError: the folder does not belong to a sweep, is in use by another process, or cannot
            be written to.
    """
    keys = [point_key(point.config) for point in plan.points]
    configs = {key: point.config for key, point in zip(keys, plan.points, strict=True)}
    folder = folder.absolute()  # a detector may change the current folder
    with sweep_folder(folder), Journal(folder / JOURNAL) as journal, kept_renderer():
        drop_results(folder)
        with durable_file(folder / COPY) as part:
            part.write_text(plan.text, encoding="utf-8")
        missing = {c: key for key, c in configs.items() if key not in journal.done}
        reused, unused = len(configs) - len(missing), len(journal.done.keys() - configs.keys())
        done = reused
        progress(done, len(configs))
        tasks = make_tasks(missing, cache or CacheOptions(), use_all_cores=use_all_cores)
        reasons: dict[str, str] = {}
        for n, results in run(measure, tasks) if tasks else ():
            of_task = [missing[config] for config in tasks[n].configs]
            reasons |= _keep(journal, dict(zip(of_task, results, strict=True)))
            done += len(results)
            progress(done, len(configs))
        if reasons:
            keyed = zip(plan.points, keys, strict=True)
            failed = [(point, reasons[key]) for point, key in keyed if key in reasons]
            return SweepResult([], failed, reused, unused)
        table = make_rows(plan.points, [journal.done[key] for key in keys])
        _write(folder, table, plan.points)
        return SweepResult(table, [], reused, unused)


def _keep(journal: Journal, results: Mapping[str, Results | Failure]) -> dict[str, str]:
    """Add results to the journal; return the reasons of failures by key."""
    journal.add((key, r) for key, r in results.items() if not isinstance(r, Failure))
    return {key: r.reason for key, r in results.items() if isinstance(r, Failure)}


def _write(folder: Path, table: Sequence[Row], points: Sequence[Point]) -> None:
    """Write the tables, and then the summary, whose presence shows that all is complete."""
    with durable_file(folder / CSV) as part:
        write_csv(part, table)
    with durable_file(folder / PARQUET) as part:
        write_parquet(part, table)
    summary = {
        "generator": GENERATOR,
        "command": "sweep",
        "points": len(points),
        "varied": list(dict.fromkeys(name for point in points for name in point.varied)),
        "versions": versions(),
        "code": code_digest(),
        "files": sorted([COPY, CSV, JOURNAL, LOCK, PARQUET, SUMMARY]),
    }
    with durable_file(folder / SUMMARY) as part:
        part.write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
