"""`flybench sweep`: any grid or random sample of runs, from a TOML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich.console import Console
from rich.table import Table

from scenarios.errors import ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.output.terminal import progress_bar, run_cli
from scenarios.pipeline.parallel import ONE_A_CORE, check_jobs, run_here, run_on_cluster
from scenarios.pipeline.run_config import RunConfig
from scenarios.sweep.folder import CSV, PARQUET, check_folder
from scenarios.sweep.measure import by_light
from scenarios.sweep.parameters import PRESET, allowed, parameter_types
from scenarios.sweep.plan import Plan, Point, read_plan
from scenarios.sweep.run import Done, Runner, finished, run_sweep

SWEEPS = Path("logs/sweep")
_SPEED_OVER_S = 3600.0
"""A point may take minutes."""
_WIDE = 1_000
"""Columns of a table that is not folded, wherever it is printed."""


@dataclass(frozen=True)
class Sweep:
    """Run every point of a grid or a random sample, and write one table."""

    file: Annotated[tyro.conf.Positional[Path | None], tyro.conf.arg(metavar="FILE.toml")] = None
    """What to vary; see scenarios/sweep/examples."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Folder to write, or to take up again; logs/sweep/ and the file's name where not given."""
    jobs: int = ONE_A_CORE
    """How many processes; -1: one a core."""
    dask: Annotated[str | None, tyro.conf.arg(metavar="ADDRESS")] = None
    """Scheduler of a Dask cluster that does the work, such as tcp://127.0.0.1:8786."""
    dry_run: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Check the file and print its points; nothing is rendered or written."""
    parameters: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """List every parameter that a file can set, its default, and what it may be."""
    cache: tyro.conf.OmitArgPrefixes[CacheOptions] = field(default_factory=CacheOptions)

    def execute(self) -> int:
        """Check, then run what is not finished yet, and write the table."""
        if self.parameters:
            print_parameters()
            return 0
        if self.file is None:
            raise ScenarioError(
                "no file is given; allowed is a TOML file, such as one of "
                "scenarios/sweep/examples; give one, or --parameters to see what it may hold"
            )
        folder = self.out or SWEEPS / self.file.stem
        run, plan = self._runner(), read_plan(self.file)
        check_folder(folder)
        self.cache.open()
        if self.dry_run:
            print_points(plan.points, finished(folder, plan.points))
            return 0
        return self._run(run, plan, folder, self.file.stem)

    def _runner(self) -> Runner:
        check_jobs(self.jobs)
        if self.dask is None:
            return partial(run_here, jobs=self.jobs)
        if self.jobs != ONE_A_CORE:
            raise ScenarioError(
                f"--jobs is {self.jobs} and --dask is {self.dask}; allowed is one of them, for a "
                "cluster has its own workers; leave the other out"
            )
        return partial(run_on_cluster, address=self.dask)

    def _run(self, run: Runner, plan: Plan, folder: Path, name: str) -> int:
        with progress_bar(_SPEED_OVER_S) as bar:
            done = run_sweep(
                plan,
                folder,
                run,
                self.cache,
                alone=self.jobs == 1,
                progress=bar.track(f"{name}, {len(plan.points)} points"),
            )
        print_done(done, plan.points, folder)
        return 1 if done.failed else 0


def print_parameters() -> None:
    """Print every parameter's name, default and type."""
    defaults: Mapping[str, Any] = RunConfig().parameters() | {PRESET: "davis346"}
    table = Table("parameter", "default", "allowed", box=None)
    for name, kind in parameter_types().items():
        default = defaults[name]
        shown = list(default) if isinstance(default, tuple) else default
        table.add_row(name, str(shown).lower() if kind is bool else str(shown), allowed(kind))
    Console(width=_WIDE).print(table)


def print_points(points: Sequence[Point], known: int) -> None:
    """Print what differs from point to point, and how much work there is."""
    labels = list(dict.fromkeys(name for point in points for name in point.labels))
    varied = list(dict.fromkeys(name for point in points for name in point.varied))
    columns = [*labels, *(name for name in varied if name not in labels)]
    table = Table("", *columns, box=None)
    for n, point in enumerate(points):
        values = dict(point.varied) | dict(point.labels)
        table.add_row(str(n), *(_shown(values.get(name, "")) for name in columns))
    console = Console(width=_WIDE)
    console.print(table)
    lights = by_light(point.config for point in points)
    console.print(f"{len(points)} points of {len(lights)} sequences; {known} are finished")


def print_done(done: Done, points: Sequence[Point], folder: Path) -> None:
    """Print what was written, what was found, and what failed."""
    if done.left_out:
        print(
            f"{done.left_out} finished points in {folder} are of another file or other code; they "
            "are kept, and left out of the table"
        )
    by_reason: dict[str, list[Point]] = {}
    for point, reason in done.failed:
        by_reason.setdefault(reason, []).append(point)
    for reason, failed in by_reason.items():
        more = f", and {len(failed) - 1} more" if len(failed) > 1 else ""
        print(f"failed: {_told(failed[0])}{more}: {reason}")
    if done.failed:
        print(
            f"{len(done.failed)} of {len(points)} points failed, so there is no table; the others "
            "are kept; mend the cause, or take these points out of the file, and start again"
        )
        return
    print(
        f"wrote {folder / CSV} and {PARQUET} beside it: {len(points)} points, of which "
        f"{done.found} were finished before"
    )


def _told(point: Point) -> str:
    values = dict(point.labels) | dict(point.varied)
    return ", ".join(f"{name} = {_shown(value)}" for name, value in values.items())


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    run_cli(Sweep)
