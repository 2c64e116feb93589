"""`flybench characterise`: the emulator's data sheet, measured, beside published figures."""

from __future__ import annotations

import json
import platform
import time
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import tyro
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from emulator import preset as named_preset
from emulator.characterisation import Section, characterise
from emulator.presets import PresetName
from scenarios.datasheet import rows
from scenarios.datasheet.numbers import as_dict
from scenarios.datasheet.page import page
from scenarios.errors import ScenarioError
from scenarios.output import check_output, whole_folder, write_summary
from scenarios.terminal import progress_bar, script

LOGS = Path("logs")
PAGE = "datasheet.html"
NUMBERS = "datasheet.json"
_WIDTH = 100
_LIBRARIES = ("flybench", "numpy", "numba", "scipy", "matplotlib")


@dataclass(frozen=True)
class Characterise:
    """Measure the emulated sensor as a real one is measured, and write its data sheet."""

    preset: PresetName = "davis346"
    """Which sensor."""
    seed: int = 0
    """Seed of everything random; the same gives the same figures."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Folder to write; a name under logs/ that tells the preset where not given."""

    def execute(self) -> int:
        """Run all experiments, write the folder, and print the figures."""
        config = named_preset(self.preset)
        if not 0 <= self.seed < 2**32:
            raise ScenarioError(
                f"--seed is {self.seed}; allowed is 0 to {2**32 - 1}; choose one, such as 0"
            )
        folder = self.out or LOGS / f"datasheet_{self.preset}_seed{self.seed}"
        check_output(folder)
        start_s = time.perf_counter()
        with progress_bar() as progress:
            sections = characterise(config, seed=self.seed, progress=progress.track(self.preset))
        wall_s = time.perf_counter() - start_s
        versions = library_versions()
        with whole_folder(folder) as work:
            sheet = page(
                sections, config=config, preset=self.preset, seed=self.seed, versions=versions
            )
            (work / PAGE).write_text(sheet, encoding="utf-8")
            numbers = as_dict(
                sections, config=config, preset=self.preset, seed=self.seed, versions=versions
            )
            text = json.dumps(numbers, indent=1, allow_nan=False, ensure_ascii=False)
            (work / NUMBERS).write_text(text + "\n", encoding="utf-8")
            write_summary(
                work,
                {
                    "command": "characterise",
                    "preset": self.preset,
                    "seed": self.seed,
                    "versions": versions,
                    "wall_s": wall_s,
                },
            )
        print_sections(sections)
        print(f"{folder / PAGE}   all experiments took {wall_s:.1f} s")
        return 0


def library_versions() -> dict[str, str]:
    """What made the data sheet."""
    return {"python": platform.python_version()} | {name: version(name) for name in _LIBRARIES}


def print_sections(sections: Mapping[str, Section]) -> None:
    """Print every figure beside the published one, a table an experiment."""
    console = Console()
    width = min(_WIDTH, console.width)
    for section in sections.values():
        table = Table(title=section.title, title_justify="left", box=SIMPLE_HEAD, width=width)
        table.add_column("figure", ratio=1)
        for head, letters in (("measured", 15), ("published", 13), ("difference", 10)):
            table.add_column(head, justify="right", no_wrap=True, width=letters)
        table.add_column("source", width=13)
        for quantity in section.quantities:
            table.add_row(
                quantity.name,
                rows.measured(quantity),
                rows.published(quantity),
                rows.difference(quantity),
                rows.short_source(quantity),
            )
        console.print(table)


if __name__ == "__main__":
    script(Characterise)
