"""`flybench characterise`: the emulator's data sheet, measured, beside published figures."""

from __future__ import annotations

import json
import platform
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from emulator.characterisation import Datasheet, characterise
from scenarios.datasheet import rows
from scenarios.datasheet.numbers import as_dict
from scenarios.datasheet.page import page
from scenarios.errors import ScenarioError
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_folder import atomic_folder, check_output_folder, write_summary
from scenarios.output.terminal import progress_bar, run_cli

LOGS = Path("logs")
PAGE = "datasheet.html"
NUMBERS = "datasheet.json"
_WIDTH = 100
_LIBRARIES = ("flybench", "numpy", "numba", "scipy", "matplotlib")


@dataclass(frozen=True)
class Characterise:
    """Measure the emulated sensor as a real one is measured, and write its data sheet."""

    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)
    seed: int = 0
    """Seed of everything random; the same gives the same figures."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Folder to write, in place of flybench's own; a telling name under logs/ where not given."""

    def execute(self) -> int:
        """Run all experiments, write the folder, and print the figures."""
        config, name = self.sensor.sensor(), self.sensor.name
        if not 0 <= self.seed < 2**32:
            raise ScenarioError(
                f"--seed is {self.seed}; allowed is 0 to {2**32 - 1}; choose one, such as 0"
            )
        folder = self.out or LOGS / f"datasheet_{name}_seed{self.seed}"
        check_output_folder(folder)
        start_s = time.perf_counter()
        with progress_bar() as progress:
            sheet = characterise(
                config, seed=self.seed, frames=self.sensor.frames, progress=progress.track(name)
            )
        wall_s = time.perf_counter() - start_s
        with atomic_folder(folder) as work:
            write_sheet(work, sheet, changes=self.sensor.changes(), wall_s=wall_s)
        print_sheet(sheet)
        print(f"{folder / PAGE}   all experiments took {wall_s:.1f} s")
        return 0


def write_sheet(work: Path, sheet: Datasheet, *, changes: Mapping[str, Any], wall_s: float) -> None:
    """Write the page, the numbers and the summary of a data sheet into a folder.

    Args:
        work: the folder, which is there.
        sheet: what was measured.
        changes: what makes the sensor, its preset included, as a file would say it.
        wall_s: how long the experiments took [s].
    """
    made = {"changes": changes, "versions": library_versions()}
    (work / PAGE).write_text(page(sheet, **made), encoding="utf-8")
    text = json.dumps(as_dict(sheet, **made), indent=1, allow_nan=False, ensure_ascii=False)
    (work / NUMBERS).write_text(text + "\n", encoding="utf-8")
    summary = {"command": "characterise", "seed": sheet.seed, "wall_s": wall_s}
    write_summary(work, summary | {"sensor": dict(changes), "versions": made["versions"]})


def library_versions() -> dict[str, str]:
    """What made the data sheet."""
    return {"python": platform.python_version()} | {name: version(name) for name in _LIBRARIES}


def print_sheet(sheet: Datasheet) -> None:
    """Print every figure beside the published one, a table an experiment.

    A narrow terminal leaves the sources to the page.
    """
    console = Console()
    width = min(_WIDTH, console.width)
    sources = width >= _WIDTH
    for section in sheet.sections.values():
        table = Table(title=section.title, title_justify="left", box=SIMPLE_HEAD, width=width)
        table.add_column("figure", ratio=1)
        for head, letters in (("measured", 15), ("published", 15), ("difference", 10)):
            table.add_column(head, justify="right", no_wrap=True, width=letters)
        if sources:
            table.add_column("source", width=13)
        for quantity in section.quantities:
            cells = (
                quantity.name,
                rows.measured(quantity),
                rows.published(quantity),
                rows.difference(quantity),
            )
            table.add_row(*cells, *((rows.short_source(quantity),) if sources else ()))
        console.print(table)
    if note := rows.footnote(sheet):
        console.print(note)


if __name__ == "__main__":
    run_cli(Characterise)
