"""`flybench characterise`: measure the emulated sensor and compare it with published figures."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich.box import SIMPLE_HEAD
from rich.table import Table

from emulator.characterisation import Datasheet, characterise
from flybench.checks import Range
from scenarios.datasheet import formatting
from scenarios.datasheet.json_export import datasheet_dict
from scenarios.datasheet.page import render_page
from scenarios.errors import ScenarioError
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_folder import atomic_folder, check_output_folder, write_summary
from scenarios.output.progress import progress_bar
from scenarios.output.streams import SafeConsole, say
from scenarios.output.terminal import run_cli
from scenarios.output.versions import versions

LOGS = Path("logs")
PAGE = "datasheet.html"
NUMBERS = "datasheet.json"
NEEDED_BYTES = 1_000_000
"""Size of the output [bytes] (measured)."""
_SEED = Range(0, 2**32 - 1)
_WIDTH = 100
"""Width of the printed tables; a narrower terminal leaves the sources out."""
_LIBRARIES = ("flybench", "numpy", "numba", "scipy", "matplotlib")


@dataclass(frozen=True)
class Characterise:
    """Measure an emulated sensor, and write its data sheet."""

    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)
    seed: int = 0
    """Random seed, from 0 to 4294967295. The same seed gives the same figures."""
    out: Annotated[
        Path | None,
        tyro.conf.arg(
            metavar="DIR", help_behavior_hint="(default: a descriptive name under logs/)"
        ),
    ] = None
    """Folder to write; an earlier result in it is replaced."""

    def execute(self) -> int:
        """Run all experiments, write the folder and print the figures."""
        config, name = self.sensor.config(), self.sensor.name
        _SEED.check("--seed", self.seed, ScenarioError, default=0)
        folder = self.out or LOGS / f"datasheet_{name}_seed{self.seed}"
        check_output_folder(folder, needed_bytes=NEEDED_BYTES)
        start_s = time.perf_counter()
        with atomic_folder(folder) as work:
            with progress_bar() as progress:
                sheet = characterise(
                    config, seed=self.seed, frames=self.sensor.frames, progress=progress.track(name)
                )
            wall_s = time.perf_counter() - start_s
            write_sheet(work, sheet, changes=self.sensor.changes(), wall_s=wall_s)
        print_sheet(sheet)
        say(f"{folder / PAGE}   all experiments took {wall_s:.1f} s")
        return 0


def write_sheet(work: Path, sheet: Datasheet, *, changes: Mapping[str, Any], wall_s: float) -> None:
    """Write the page, the JSON file and the summary of a data sheet into a folder.

    Args:
        work: existing folder.
        sheet: results of the experiments.
        changes: preset of the sensor and its changed settings, by name.
        wall_s: duration of the experiments [s].
    """
    context = {"changes": changes, "versions": versions(_LIBRARIES)}
    (work / PAGE).write_text(render_page(sheet, **context), encoding="utf-8")
    text = json.dumps(
        datasheet_dict(sheet, **context), indent=1, allow_nan=False, ensure_ascii=False
    )
    (work / NUMBERS).write_text(text + "\n", encoding="utf-8")
    summary = {"command": "characterise", "seed": sheet.seed, "wall_s": wall_s}
    write_summary(work, summary | {"sensor": dict(changes), "versions": context["versions"]})


def print_sheet(sheet: Datasheet) -> None:
    """Print each experiment as a table of measured and published figures."""
    console = SafeConsole()
    width = min(_WIDTH, console.width)
    shows_sources = width >= _WIDTH
    for section in sheet.sections.values():
        table = Table(title=section.title, title_justify="left", box=SIMPLE_HEAD, width=width)
        table.add_column("figure", ratio=1)
        for head, letters in (("measured", 15), ("published", 15), ("difference", 10)):
            table.add_column(head, justify="right", no_wrap=True, width=letters)
        if shows_sources:
            table.add_column("source", width=13)
        for quantity in section.quantities:
            cells = (
                quantity.name,
                formatting.measured(quantity),
                formatting.published(quantity),
                formatting.difference(quantity),
            )
            table.add_row(*cells, *((formatting.short_source(quantity),) if shows_sources else ()))
        console.print(table)
    if note := formatting.footnote(sheet):
        console.print(note)


if __name__ == "__main__":
    run_cli(Characterise)
