"""Options of a command that reads a recording of events."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from formats import FORMATS, SORT_MAX_US, EventFile, open_events
from scenarios.errors import ScenarioError
from scenarios.output.atomic_folder import EVENTS
from scenarios.output.streams import complain

_SIZE = re.compile(r"(\d{1,5})[x×](\d{1,5})")
_FROM_FILE = "(default: from the file, or inferred from its values)"


@dataclass(frozen=True)
class RecordingOptions:
    """What a recording does not state, or states wrongly."""

    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint=_FROM_FILE)] = None
    """Sensor size [px], such as 346x260, if the file does not state it, or states a wrong size."""
    format: Annotated[
        str | None,
        tyro.conf.arg(
            metavar="NAME",
            help=f"Format of the file, if it is not recognised: {', '.join(FORMATS)}.",
            help_behavior_hint="(default: recognised by the file's first bytes)",
        ),
    ] = None
    time_unit: Annotated[
        str | None, tyro.conf.arg(metavar="s|ms|us|ns", help_behavior_hint=_FROM_FILE)
    ] = None
    """Unit of the timestamps, if the table states a wrong one; 1/30s for frame numbers at 30 Hz."""
    columns: Annotated[str | None, tyro.conf.arg(metavar="txyp", help_behavior_hint=_FROM_FILE)] = (
        None
    )
    """Order of the columns of text or of a table of numbers; - for a column that is not read."""
    sort: Annotated[
        float | None,
        tyro.conf.arg(metavar="MS", help_behavior_hint="(default: refuse late events)"),
    ] = None
    """Put events in order that come late by no more than this time [ms], up to 10000."""
    drop_unsorted: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Drop events that come late, by more than --sort if given, and single ones from the future."""

    def open(self, path: Path) -> EventFile:
        """Open a recording with these options, and print what is uncertain about it.

        Raises:
            FormatError: the file cannot be read.
            ScenarioError: the size is not written as a size, or the time is not a number above 0.
        """
        return open_recording(
            path,
            format=self.format,
            size=self._size(),
            time_unit=self.time_unit,
            columns=self.columns,
            sort_within_us=self._sort_within_us(),
            drop_unsorted=self.drop_unsorted,
        )

    def _sort_within_us(self) -> int:
        if self.sort is None:
            return 0
        if not 0 < self.sort <= SORT_MAX_US / 1e3:
            raise ScenarioError(
                f"--sort is {self.sort:g}. Allowed is a time above 0 and up to "
                f"{SORT_MAX_US / 1e3:g} ms, because all events of that time are held in memory."
            )
        return math.ceil(self.sort * 1e3)

    def _size(self) -> tuple[int, int] | None:
        if self.size is None:
            return None
        sides = _SIZE.fullmatch(self.size.strip())
        if sides is None:
            raise ScenarioError(
                f"--size is {self.size!r}. Allowed is width and height in pixels, such as --size "
                "346x260."
            )
        return int(sides[1]), int(sides[2])


def open_recording(path: Path, **options: Any) -> EventFile:
    """Open a recording, and print what is uncertain about it.

    Args:
        path: the file.
        options: arguments of `formats.open_events`.

    Raises:
        FormatError: the file cannot be read.
    """
    file = open_events(path, **options)
    for warning in file.warnings:
        complain(f"warning: {warning}")
    return file


def events_file(path: Path) -> Path:
    """Return the file of events in the folder of a flybench run, or else `path` itself."""
    events = path / EVENTS
    return events if events.is_file() else path
