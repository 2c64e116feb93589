"""`flybench demo`: the paper's second speed, by day and by night."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from scenarios.commands.run import LOGS, Run
from scenarios.options.method import MethodName
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_folder import check_output_folder
from scenarios.output.progress import progress_bar
from scenarios.output.terminal import report_failures, run_cli
from scenarios.pipeline.frame_check import check_frames
from scenarios.pipeline.registry import FLY
from scenarios.pipeline.running import make_detector
from scenarios.runs.run_table import print_runs
from scenarios.runs.sequence import estimated_bytes, failures, record_run


@dataclass(frozen=True)
class Demo:
    """Run one crossing by day and one by night, and compare them."""

    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = LOGS / "demo"
    """Folder to write; the sequences go to its folders day and night."""
    method: MethodName = FLY
    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)

    def execute(self) -> int:
        """Run both sequences and print the table."""
        runs = [
            (self.out / lighting, Run(lighting, method=self.method, sensor=self.sensor).config())
            for lighting in ("day", "night")
        ]
        check_frames(self.sensor.preset, self.method)
        needed_bytes = sum(estimated_bytes(config) for _, config in runs)
        places = [folder.absolute() for folder, _ in runs]  # a detector may change the current one
        for folder, config in runs:
            check_output_folder(folder, needed_bytes=needed_bytes)
            make_detector(config)
        with progress_bar() as progress:
            summaries = [
                (folder, record_run(config, place, progress.track(config.title)))
                for (folder, config), place in zip(runs, places, strict=True)
            ]
        print_runs(summaries)
        return report_failures(reason for _, summary in summaries for reason in failures(summary))


if __name__ == "__main__":
    run_cli(Demo)
