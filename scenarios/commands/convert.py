"""`flybench convert`: convert a recording to another format, or cut it."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from formats import ENDINGS, WRITERS, EventFile, open_writer
from scenarios.commands.detect import check_not_empty, check_not_rerun
from scenarios.convert.copying import Totals, copy
from scenarios.convert.report import print_conversion
from scenarios.convert.section import LATEST_US, Crop, Section
from scenarios.errors import ScenarioError
from scenarios.options.recording import RecordingOptions, events_file
from scenarios.output.atomic_file import check_output_file
from scenarios.output.progress import progress_bar
from scenarios.output.terminal import run_cli

_CROP = re.compile(r"(\d{1,5}),(\d{1,5}),(\d{1,5}),(\d{1,5})")
_LONGEST_S = 1e9
"""Largest time of an option, 31 years [s]."""


@dataclass(frozen=True)
class Convert:
    """Convert a recording, or cut it in time or space."""

    file: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="IN")]
    """Recording to read, or the folder of a flybench run."""
    out: Annotated[
        Path,
        tyro.conf.Positional,
        tyro.conf.arg(
            metavar="OUT",
            help=f"File to write; its ending states the format: {', '.join(ENDINGS)}.",
        ),
    ]
    from_s: Annotated[
        float | None,
        tyro.conf.arg(name="from", metavar="S", help_behavior_hint="(default: the start)"),
    ] = None
    """Start of the section to write [s], in the times that `flybench detect` shows."""
    to_s: Annotated[
        float | None, tyro.conf.arg(name="to", metavar="S", help_behavior_hint="(default: the end)")
    ] = None
    """End of the section to write, exclusive [s]. Times are not changed."""
    crop: Annotated[
        str | None,
        tyro.conf.arg(metavar="X0,Y0,X1,Y1", help_behavior_hint="(default: the whole sensor)"),
    ] = None
    """Part of the sensor to write: columns X0 to X1 - 1, rows Y0 to Y1 - 1. X0, Y0 becomes 0, 0."""
    out_format: Annotated[
        str | None,
        tyro.conf.arg(
            metavar="NAME",
            help=f"Format to write: {', '.join(WRITERS)}. rosbag2 is a folder.",
            help_behavior_hint="(default: by the ending)",
        ),
    ] = None
    salvage: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """If the file is damaged, write what comes before the damage, and print a warning."""
    overwrite: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Replace OUT if it is an existing file."""
    input: tyro.conf.OmitArgPrefixes[RecordingOptions] = field(default_factory=RecordingOptions)

    def execute(self) -> int:
        """Read, cut and write the recording, and print the counts."""
        path = events_file(self.file)
        self._check_out(path)
        from_us, to_us = self._span_us()
        check_not_rerun(path)
        with self.input.open(path) as file:
            section = Section(from_us, to_us, self._crop_of(file))
            width, height = self._size_of(file, section)
            with open_writer(
                self.out,
                width=width,
                height=height,
                format=self.out_format,
                overwrite=self.overwrite,
            ) as writer:
                with progress_bar() as progress:
                    advance = progress.track(file.path.name)
                    totals = copy(file, section, writer, advance, salvage=self.salvage)
                self._check_result(file, totals)
        print_conversion(file, self.out, totals)
        return 0

    def _span_us(self) -> tuple[int, int]:
        for name, value in (("--from", self.from_s), ("--to", self.to_s)):
            if value is not None and not 0 <= value <= _LONGEST_S:
                raise ScenarioError(
                    f"{name} is {value:g}. Allowed is 0 to {_LONGEST_S:.0f} s. Give a time in the "
                    "recording, as flybench detect shows it."
                )
        from_us = -LATEST_US if self.from_s is None else round(self.from_s * 1e6)
        to_us = LATEST_US if self.to_s is None else round(self.to_s * 1e6)
        if from_us >= to_us:
            raise ScenarioError(
                f"--from is {self.from_s or 0:g} and --to is {self.to_s:g}. Allowed is a start "
                "before the end. Exchange them."
            )
        return from_us, to_us

    def _crop_of(self, file: EventFile) -> Crop | None:
        if self.crop is None:
            return None
        found = _CROP.fullmatch(self.crop.replace(" ", ""))
        crop = Crop(*map(int, found.groups())) if found else Crop(0, 0, 0, 0)
        if not (crop.x0 < crop.x1 <= file.width and crop.y0 < crop.y1 <= file.height):
            raise ScenarioError(
                f"--crop is {self.crop!r}. Allowed is X0,Y0,X1,Y1 with X0 < X1 <= {file.width} and "
                f"Y0 < Y1 <= {file.height}, the size of this sensor."
            )
        return crop

    @staticmethod
    def _size_of(file: EventFile, section: Section) -> tuple[int, int]:
        if section.crop is None:
            return file.width, file.height
        return section.crop.x1 - section.crop.x0, section.crop.y1 - section.crop.y0

    def _check_out(self, source: Path) -> None:
        out = self.out.resolve()
        if out in (source.resolve(), self.file.resolve()) or source.resolve() in out.parents:
            raise ScenarioError(
                f"OUT is {self.out}, which is the recording to read, or part of it. Choose another "
                "name."
            )
        if self.out_format != "rosbag2":
            check_output_file(self.out, "OUT", overwrite=self.overwrite)

    def _check_result(self, file: EventFile, totals: Totals) -> None:
        check_not_empty(file)
        if not totals.written.events and not totals.written.frames:
            found = file.statistics
            raise ScenarioError(
                f"{file.path} has no event in that section, so nothing was written. Its events are "
                f"from {found.first_us * 1e-6:.6f} s to {found.last_us * 1e-6:.6f} s, in x from "
                f"{found.x_min} to {found.x_max} and y from {found.y_min} to {found.y_max}."
            )


if __name__ == "__main__":
    run_cli(Convert)
