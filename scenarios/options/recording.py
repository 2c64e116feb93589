"""Options of a command that reads a recording of events."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from formats import FORMATS, EventFile, open_events
from scenarios.errors import ScenarioError
from scenarios.output.atomic_folder import EVENTS

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
    """Unit of the timestamps, if a text, HDF5, NumPy or MATLAB file does not state it."""

    def open(self, path: Path) -> EventFile:
        """Open a recording with these options.

        Raises:
            FormatError: the file cannot be read.
            ScenarioError: the size is not written as a size.
        """
        return open_events(path, format=self.format, size=self._size(), time_unit=self.time_unit)

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


def events_file(path: Path) -> Path:
    """Return the file of events in the folder of a flybench run, or else `path` itself."""
    events = path / EVENTS
    return events if events.is_file() else path
