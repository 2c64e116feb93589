"""`flybench compare`: compare two recordings by the statistics that matter for detectors."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from formats import EventFile
from scenarios.commands.detect import check_not_rerun
from scenarios.compare.compared import compare_statistics
from scenarios.compare.json_export import comparison_dict
from scenarios.compare.plot import write_plot
from scenarios.compare.table import print_comparison
from scenarios.errors import ScenarioError
from scenarios.event_statistics.recording_statistics import RecordingStatistics, statistics_of
from scenarios.options.recording import RecordingOptions, events_file
from scenarios.output.atomic_file import atomic_file, check_output_file
from scenarios.output.streams import SafeConsole, say
from scenarios.output.terminal import run_cli


@dataclass(frozen=True)
class Compare:
    """Compare two recordings, such as a real and an emulated one."""

    a: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="A")]
    """First recording, or the folder of a flybench run."""
    b: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="B")]
    """Second recording, or the folder of a flybench run. The options apply to both."""
    json: bool = False
    """Print one JSON document with both recordings and all distances instead of the table."""
    plot: Annotated[
        Path | None, tyro.conf.arg(metavar="PNG", help_behavior_hint="(default: no figure)")
    ] = None
    """Also write a figure (.png) of the distributions and the distances."""
    overwrite: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Replace the figure if it exists."""
    input: tyro.conf.OmitArgPrefixes[RecordingOptions] = field(default_factory=RecordingOptions)

    def execute(self) -> int:
        """Read both recordings, print the comparison and write the figure."""
        paths = events_file(self.a), events_file(self.b)
        self._check_plot(paths)
        read = [self._read(path) for path in paths]
        files = read[0][0], read[1][0]
        statistics = read[0][1], read[1][1]
        rows = compare_statistics(*statistics)
        if self.plot:
            with atomic_file(self.plot, overwrite=self.overwrite) as png:
                write_plot(png, (f"A: {paths[0].name}", f"B: {paths[1].name}"), statistics, rows)
        if self.json:
            say(json.dumps(comparison_dict(files, statistics, rows), allow_nan=False))
        else:
            print_comparison(SafeConsole(), files, statistics, rows)
        if self.plot:
            console = SafeConsole(stderr=True) if self.json else SafeConsole()
            console.print(f"wrote {self.plot}", soft_wrap=True)
        return 0

    def _read(self, path: Path) -> tuple[EventFile, RecordingStatistics]:
        check_not_rerun(path)
        with self.input.open(path) as file:
            found = statistics_of(file, width=file.width, height=file.height)
        if file.statistics.span_us == 0:
            raise ScenarioError(
                f"{path} contains {found.events:,} events in 0 s. Allowed is a recording with "
                "events at two times or more. Record it again, or give another file."
            )
        return file, found

    def _check_plot(self, sources: tuple[Path, Path]) -> None:
        if self.plot is None:
            return
        if self.plot.suffix.lower() != ".png":
            raise ScenarioError(
                f"--plot is {self.plot}. Allowed is a name that ends in .png. Add the ending."
            )
        check_output_file(self.plot, "--plot", overwrite=self.overwrite, sources=sources)


if __name__ == "__main__":
    run_cli(Compare)
