"""`flybench sweep`: run a grid or a random sample of points from a TOML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich.table import Table

from scenarios.errors import ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_file import atomic_file, check_output_file
from scenarios.output.numbers import counted
from scenarios.output.progress import progress_bar
from scenarios.output.streams import SafeConsole, say, table_width
from scenarios.output.terminal import run_cli
from scenarios.pipeline.cluster import run_on_cluster
from scenarios.pipeline.parallel import ONE_PER_CORE, check_jobs, run_locally
from scenarios.pipeline.run_config import RunConfig
from scenarios.sweep.folder import CSV, PARQUET, check_folder
from scenarios.sweep.measure import group_by_sequence
from scenarios.sweep.parameters import PRESET, allowed, parameter_types
from scenarios.sweep.plan import Plan, Point, read_plan
from scenarios.sweep.plot import VALUE, write_plot
from scenarios.sweep.run import Runner, SweepResult, count_finished, run_sweep

SWEEPS = Path("logs/sweep")
_SPEED_OVER_S = 3600.0
"""Time over which the progress display averages the speed [s]; a point may take minutes."""


@dataclass(frozen=True)
class Sweep:
    """Run all points of a grid or a random sample; write one table."""

    file: Annotated[
        tyro.conf.Positional[Path | None],
        tyro.conf.arg(metavar="FILE.toml", help_behavior_hint=""),
    ] = None
    """File with the parameters to vary. Examples are in scenarios/sweep/examples."""
    out: Annotated[
        Path | None,
        tyro.conf.arg(
            metavar="DIR", help_behavior_hint="(default: logs/sweep/ and the name of the file)"
        ),
    ] = None
    """Output folder; an interrupted sweep in it is resumed."""
    jobs: int = ONE_PER_CORE
    """Number of processes, 1 or more; -1: one per core."""
    dask: Annotated[
        str | None,
        tyro.conf.arg(metavar="ADDRESS", help_behavior_hint="(default: no cluster)"),
    ] = None
    """Run on a Dask cluster: address of its scheduler, such as tcp://127.0.0.1:8786."""
    dry_run: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Check the file and print its points, but render and write nothing."""
    plot: Annotated[
        Path | None, tyro.conf.arg(metavar="PNG", help_behavior_hint="(default: no figure)")
    ] = None
    """Also write a figure (.png) of one value against the parameters that vary."""
    plot_value: Annotated[str, tyro.conf.arg(metavar="COLUMN")] = VALUE
    """Column of results.csv that --plot shows: by default, the share of correct steps."""
    overwrite: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Replace an existing file of --plot."""
    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)
    parameters: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """List every parameter that a file can set, with its default and allowed values."""
    cache: tyro.conf.OmitArgPrefixes[CacheOptions] = field(default_factory=CacheOptions)

    def execute(self) -> int:
        """Check the file, run the points that are not finished, and write the table."""
        if self.parameters:
            print_parameters()
            return 0
        if self.file is None:
            raise ScenarioError(
                "No file is given. Allowed is a TOML file, such as those in "
                "scenarios/sweep/examples. Give a file, or --parameters to list what it can set."
            )
        folder = self.out or SWEEPS / self.file.stem
        self._check_plot(self.file)
        run, plan = self._runner(), read_plan(self.file, self.sensor)
        check_folder(folder)
        self.cache.open()
        if self.dry_run:
            print_points(plan.points, count_finished(folder, plan.points))
            return 0
        return self._run(run, plan, folder, self.file.stem)

    def _runner(self) -> Runner:
        check_jobs(self.jobs)
        if self.dask is None:
            return partial(run_locally, jobs=self.jobs)
        if self.jobs != ONE_PER_CORE:
            raise ScenarioError(
                f"--jobs is {self.jobs} and --dask is {self.dask}. Allowed is only one of them, "
                "because a cluster has its own workers. Leave the other out."
            )
        return partial(run_on_cluster, address=self.dask)

    def _run(self, run: Runner, plan: Plan, folder: Path, name: str) -> int:
        with progress_bar(_SPEED_OVER_S) as bar:
            result = run_sweep(
                plan,
                folder,
                run,
                self.cache,
                use_all_cores=self.jobs == 1,
                progress=bar.track(f"{name}, {counted(len(plan.points), 'point')}"),
            )
        print_result(result, plan.points, folder)
        if self.plot is not None and not result.failed:
            with atomic_file(self.plot, overwrite=self.overwrite) as png:
                write_plot(png, plan.points, result.table, self.plot_value)
            say(f"wrote {self.plot}")
        return 1 if result.failed else 0

    def _check_plot(self, source: Path) -> None:
        if self.plot is None:
            return
        if self.plot.suffix.lower() != ".png":
            raise ScenarioError(
                f"--plot is {self.plot}. Allowed is a name that ends in .png. Add the ending."
            )
        check_output_file(self.plot, "--plot", overwrite=self.overwrite, sources=(source,))


def print_parameters() -> None:
    """Print the name, default and allowed values of every parameter."""
    defaults: Mapping[str, Any] = RunConfig().parameters() | {PRESET: "davis346"}
    table = Table("parameter", "default", "allowed", box=None)
    for name, kind in parameter_types().items():
        default = defaults[name]
        shown = list(default) if isinstance(default, tuple) else default
        table.add_row(name, str(shown).lower() if kind is bool else str(shown), allowed(kind))
    SafeConsole(width=table_width()).print(table)


def print_points(points: Sequence[Point], finished: int) -> None:
    """Print what varies from point to point, and the number of points and sequences."""
    labels = list(dict.fromkeys(name for point in points for name in point.labels))
    varied = list(dict.fromkeys(name for point in points for name in point.varied))
    columns = [*labels, *(name for name in varied if name not in labels)]
    table = Table("", *columns, box=None)
    for n, point in enumerate(points):
        values = dict(point.varied) | dict(point.labels)
        table.add_row(str(n), *(_format(values.get(name, "")) for name in columns))
    console = SafeConsole(width=table_width())
    console.print(table)
    sequences = group_by_sequence(point.config for point in points)
    console.print(
        f"{counted(len(points), 'point')} of {counted(len(sequences), 'sequence')}; {finished} "
        "finished"
    )


def print_result(result: SweepResult, points: Sequence[Point], folder: Path) -> None:
    """Print what was written, what was reused, and what failed."""
    if result.unused:
        say(
            f"{folder} also has {counted(result.unused, 'finished point')} from another file or "
            "other code. This is kept, but is not in the table."
        )
    by_reason: dict[str, list[Point]] = {}
    for point, reason in result.failed:
        by_reason.setdefault(reason, []).append(point)
    for reason, failed in by_reason.items():
        more = f", and {len(failed) - 1} more" if len(failed) > 1 else ""
        say(f"failed: {_describe(failed[0])}{more}: {reason}")
    if result.failed:
        say(
            f"{len(result.failed)} of {counted(len(points), 'point')} failed, so no table is "
            "written. The results of the others are kept. Remove the cause, or these points from "
            "the file, and start again."
        )
        return
    say(
        f"wrote {folder / CSV} and {PARQUET} in the same folder: {counted(len(points), 'point')}, "
        f"{result.reused} finished before"
    )


def _describe(point: Point) -> str:
    values = dict(point.labels) | dict(point.varied)
    return ", ".join(f"{name} = {_format(value)}" for name, value in values.items())


def _format(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    run_cli(Sweep)
