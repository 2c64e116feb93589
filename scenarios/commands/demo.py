"""`flybench demo`: the paper's second speed, once by day and once by night."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from scenarios.commands.run import LOGS, Run
from scenarios.output.folder import check_output
from scenarios.output.terminal import progress_bar, script
from scenarios.pipeline.registry import FLY
from scenarios.pipeline.running import make_detector
from scenarios.runs.run_table import print_runs
from scenarios.runs.sequence import run_sequence


@dataclass(frozen=True)
class Demo:
    """Run one day and one night sequence, vehicle moving right, and compare them in a table."""

    out: Path = LOGS / "demo"
    """Folder to write both to."""
    method: Annotated[str, tyro.conf.arg(metavar="NAME")] = FLY
    """Detector: fly, wide, or a class of your own as package.module:Class."""

    def execute(self) -> int:
        """Run both, and print the closing table."""
        runs = [
            (self.out / "day", Run(lighting="day", method=self.method).config()),
            (self.out / "night", Run(lighting="night", method=self.method).config()),
        ]
        for folder, config in runs:
            check_output(folder)
            make_detector(config)
        with progress_bar() as progress:
            summaries = [
                (folder, run_sequence(config, folder, progress.track(config.name)))
                for folder, config in runs
            ]
        print_runs(summaries)
        return 0


if __name__ == "__main__":
    script(Demo)
