"""`flybench envelope`: where a detector is right, over speed, noise and all else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import tyro
from rich.console import Console
from rich.table import Table

from detector.estimate import FrameDetector
from scenarios.envelope.grid import BASE, LEVELS, NOISE, NOISES_HZ, SPEED, SPEEDS_PX_S, Grid
from scenarios.envelope.maps import draw_comparison, draw_levels, draw_method
from scenarios.envelope.parallel import measure_all
from scenarios.envelope.table import (
    HOLDS,
    NONE,
    OPPOSITE,
    RIGHT,
    Row,
    at_base,
    levels,
    means,
    range_that_holds,
)
from scenarios.errors import ScenarioError
from scenarios.options.method import RepeatedMethod
from scenarios.output.atomic_folder import atomic_folder, check_output_folder, write_summary
from scenarios.output.tables import write_table
from scenarios.output.terminal import progress_bar, run_cli
from scenarios.pipeline.registry import FLY
from scenarios.pipeline.summary import versions
from scenarios.pipeline.user_detectors import find_method
from scenarios.runs.run_table import percent

TABLE = "envelope.csv"
SEEDS, SEEDS_IN_FULL = 2, 10
_SLIDES = {RIGHT: "", OPPOSITE: "_opposite", NONE: "_none"}
"""What is drawn, and how the names of the files end."""
Factor = Literal["contrast", "direction", "length_px", "surface", "background"]


@dataclass(frozen=True)
class Envelope:
    """Measure where a detector is right, on drawn stimuli, and draw it as maps."""

    REPEATABLE: ClassVar = frozenset({"--method"})
    method: RepeatedMethod = ()
    full: bool = False
    """Ten drawings of every point instead of two."""
    seeds: int | None = None
    """How many drawings of every point, instead."""
    speeds: tuple[float, ...] = SPEEDS_PX_S
    """Image speeds [px/s]."""
    noises: tuple[float, ...] = NOISES_HZ
    """Noise of every pixel [Hz]."""
    cross: tuple[Factor, ...] = ("direction",)
    """Factors to measure at every speed and noise, not at every speed alone."""
    only: tuple[Factor, ...] | None = None
    """Factors to vary at all; every one where not given."""
    jobs: int = -1
    """How many processes; -1: one a core."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("logs/envelope")
    """Folder to write; takes the place of what flybench wrote there before."""

    @property
    def methods(self) -> tuple[str, ...]:
        """Names of the methods, each once."""
        return tuple(dict.fromkeys(self.method)) or (FLY,)

    def grid(self) -> Grid:
        """What the arguments ask for.

        Raises:
            ScenarioError: a value that a stimulus cannot have, or no level at all.
        """
        names = LEVELS if self.only is None else {*self.only, *self.cross}
        seeds = self.seeds if self.seeds is not None else SEEDS_IN_FULL if self.full else SEEDS
        speeds, noises = tuple(sorted(set(self.speeds))), tuple(sorted(set(self.noises)))
        kept = {name: levels for name, levels in LEVELS.items() if name in names}
        return Grid(speeds, noises, kept, self.cross, seeds)

    def execute(self) -> int:
        """Measure, write the folder, and print the ranges."""
        grid = self.grid()
        for name in self.methods:
            _check_method(name)
        check_output_folder(self.out)
        with progress_bar() as progress:
            advance = progress.track(f"envelope of {', '.join(self.methods)}")
            rows = measure_all(grid.points(), self.methods, jobs=self.jobs, progress=advance)
        with atomic_folder(self.out) as work:
            write_envelope(work, rows, grid, asdict(replace(self, method=self.methods)))
        print_envelope(rows, grid)
        print(f"wrote {self.out}")
        return 0


def _check_method(name: str) -> None:
    detector = find_method(name).make(width=BASE.width, height=BASE.height)
    if isinstance(detector, FrameDetector):
        raise ScenarioError(
            f"the method {name} looks at frames, and an envelope's stimuli are events alone; "
            "allowed are methods without push_frame; measure this one with flybench velocity-sweep"
        )


def write_envelope(work: Path, rows: Sequence[Row], grid: Grid, arguments: dict[str, Any]) -> None:
    """Write the table, the maps and the summary.

    Args:
        work: an empty folder.
        rows: of `measure_all`.
        grid: what was measured.
        arguments: of the command.
    """
    write_table(work / TABLE, tuple(rows[0]), (tuple(row.values()) for row in rows))
    methods = levels(rows, "method")
    for method in methods:
        own = [row for row in rows if row["method"] == method]
        for value, ending in _SLIDES.items():
            draw_method(work / f"{_file_name(method)}{ending}", own, value, crossed=grid.crossed)
    if len(methods) > 1:
        draw_comparison(work / "comparison", rows, crossed=grid.crossed)
    for factor in grid.crossed:
        draw_levels(work / f"by_{factor}", rows, factor)
    write_summary(
        work,
        {
            "command": "envelope",
            "parameters": arguments | {"out": str(arguments["out"])},
            "grid": asdict(grid),
            "base": asdict(BASE),
            "versions": versions(),
            "holds": {method: _holds(rows, method) for method in methods},
        },
    )


def print_envelope(rows: Sequence[Row], grid: Grid) -> None:
    """Print right steps by speed and noise, a table a method, and the range in which it holds."""
    console = Console()
    for method in levels(rows, "method"):
        own = [row for row in rows if row["method"] == method]
        full = at_base(own, (SPEED, NOISE, *grid.crossed))
        table = Table(title=f"{method}: right steps after 100 ms in view", title_justify="left")
        table.add_column("px/s", justify="right")
        for noise in levels(full, NOISE):
            table.add_column(f"{noise:g} Hz", justify="right")
        shares = means(full, SPEED, NOISE, RIGHT)
        for speed, column in zip(levels(full, SPEED), shares.T, strict=True):
            cells = (None if share != share else float(share) for share in column)
            table.add_row(f"{speed:g}", *(percent(cell) for cell in cells))
        console.print(table)
        console.print(f"{method} holds {_told(_holds(rows, method))}", soft_wrap=True)


def _holds(rows: Sequence[Row], method: str) -> dict[str, list[float] | None]:
    """By noise: slowest and fastest of the speeds at which 95 % of the steps are right [px/s]."""
    own = at_base([r for r in rows if r["method"] == method], (SPEED, NOISE, "direction"))
    found: dict[str, list[float] | None] = {}
    for noise in levels(own, NOISE):
        span = range_that_holds([row for row in own if row[NOISE] == noise])
        found[f"{noise:g}"] = None if span is None else list(span)
    return found


def _told(holds: dict[str, list[float] | None]) -> str:
    parts = [
        f"at {noise} Hz " + ("nowhere" if span is None else f"from {span[0]:g} to {span[1]:g} px/s")
        for noise, span in holds.items()
    ]
    return f"{100 * HOLDS:.0f} %: " + "; ".join(parts)


def _file_name(method: str) -> str:
    return method.replace(":", ".")


if __name__ == "__main__":
    run_cli(Envelope)
