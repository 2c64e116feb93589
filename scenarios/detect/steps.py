"""Estimates as a table on the terminal and as JSON, written as they come."""

from __future__ import annotations

import json
import shutil
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import IO, Any, Self, TextIO

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from detector.estimate import MotionEstimate
from flybench.direction import Direction
from formats import EventFile
from scenarios.detect.tally import Verdict
from scenarios.recording.entities import ARROW

PAGE = 50
"""Rows that are printed at a time."""
_COLUMNS = (("time [s]", 13), ("HS", 7), ("VS", 7), ("direction", 10), ("strength", 9))


class StepsPrinter(ABC):
    """Prints estimates as they come, and the verdict; use it as a context manager."""

    def __enter__(self) -> Self:
        return self

    @abstractmethod
    def __exit__(self, *_: object) -> None:
        """Let go of what is open."""

    @abstractmethod
    def add(self, estimate: MotionEstimate) -> None:
        """Add a step."""

    @abstractmethod
    def finish(
        self, file: EventFile, method: str, settings: Mapping[str, Any], verdict: Verdict
    ) -> None:
        """Print the file's facts and the verdict.

        Args:
            file: read to its end.
            method: name of the detector.
            settings: what was scaled about it, by name.
            verdict: of all steps.
        """


class StepsTable(StepsPrinter):
    """A table that grows while the file is read."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._waiting: list[MotionEstimate] = []
        self._begun = False

    def __exit__(self, *_: object) -> None:
        self._flush()

    def add(self, estimate: MotionEstimate) -> None:
        """Add a row."""
        self._waiting.append(estimate)
        if len(self._waiting) >= PAGE:
            self._flush()

    def finish(
        self, file: EventFile, method: str, settings: Mapping[str, Any], verdict: Verdict
    ) -> None:
        """Print the rest, and a closing table."""
        self._flush()
        self._console.print(_closing_table(file, method, settings, verdict))

    def _flush(self) -> None:
        if not self._waiting:
            return
        table = Table(box=None, show_header=not self._begun, pad_edge=False)
        for name, width in _COLUMNS:
            justify: Any = "left" if name == "direction" else "right"
            table.add_column(name, justify=justify, width=width)
        for e in self._waiting:
            way = f"{ARROW.get(e.direction, ' ')} {e.direction.value}"
            row = f"{e.t_us * 1e-6:.3f}", f"{e.hs:+.3f}", f"{e.vs:+.3f}", way, f"{e.strength:.3f}"
            table.add_row(*row, style="dim" if e.direction is Direction.NONE else None)
        self._console.print(table)
        self._begun, self._waiting = True, []


class StepsJson(StepsPrinter):
    """A JSON document that is printed only once it is whole; kept on disk until then."""

    def __init__(self, to: TextIO) -> None:
        self._to = to
        self._file: IO[str] = tempfile.TemporaryFile(  # noqa: SIM115  (closed on exit)
            "w+", encoding="utf-8"
        )
        self._file.write('{"steps": [')
        self._separator = "\n"

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def add(self, estimate: MotionEstimate) -> None:
        """Add a step."""
        self._file.write(self._separator + json.dumps(_step(estimate)))
        self._separator = ",\n"

    def finish(
        self, file: EventFile, method: str, settings: Mapping[str, Any], verdict: Verdict
    ) -> None:
        """End the document and print it."""
        tail = {
            "direction": verdict.direction.value,
            "share": verdict.share,
            "method": method,
            "scaled": dict(settings),
            "file": {"name": str(file.path), **_facts(file)},
        }
        self._file.write("\n], " + json.dumps(tail)[1:] + "\n")
        self._file.seek(0)
        shutil.copyfileobj(self._file, self._to)
        self._to.flush()


def _step(estimate: MotionEstimate) -> dict[str, Any]:
    """An estimate, as JSON has it."""
    e = estimate
    return {
        "t_us": int(e.t_us),
        "hs": float(e.hs),
        "vs": float(e.vs),
        "direction": e.direction.value,
        "strength": float(e.strength),
    }


def _rows(file: EventFile) -> list[tuple[str, str]]:
    """What a file says and what was found in it, once it was read."""
    found = file.statistics
    rows = [
        ("format", file.format),
        ("sensor", f"{file.width} × {file.height} px, from {file.size_from}"),
        ("events", f"{found.events:,} in {found.span_us * 1e-6:,.3f} s"),
        ("from, to", f"{found.first_us * 1e-6:,.6f} s, {found.last_us * 1e-6:,.6f} s"),
        ("rate", f"{found.rate_hz * 1e-3:,.1f} kev/s"),
        ("ON, OFF", f"{found.on_share:.1%}, {1 - found.on_share:.1%}" if found.events else "none"),
        ("x, y", f"{found.x_min} to {found.x_max}, {found.y_min} to {found.y_max}"),
        ("frames", f"{found.frames:,}"),
    ]
    if file.origin_us:
        rows.insert(4, ("time 0 is", f"{file.origin_us:,} µs of the file"))
    return rows


def _facts(file: EventFile) -> dict[str, Any]:
    """The same for a program."""
    found = file.statistics
    return {
        "format": file.format,
        "width": file.width,
        "height": file.height,
        "size_from": file.size_from,
        "says": file.header_facts,
        "origin_us": file.origin_us,
        "events": found.events,
        "first_us": found.first_us,
        "last_us": found.last_us,
        "rate_hz": found.rate_hz,
        "on_share": found.on_share,
        "frames": found.frames,
    }


def _closing_table(
    file: EventFile, method: str, settings: Mapping[str, Any], verdict: Verdict
) -> Table:
    """The file, what was found in it, and the verdict."""
    table = Table(title=escape(str(file.path)), title_justify="left", show_header=False)
    for name, value in _rows(file):
        table.add_row(name, value)
    for name, value in file.header_facts.items():
        table.add_row(escape(f"it says: {name}"), escape(value))
    table.add_section()
    table.add_row("method", escape(method))
    if settings:
        table.add_row("scaled", ", ".join(f"{name} = {value}" for name, value in settings.items()))
    table.add_row("steps", _told_steps(verdict))
    way = verdict.direction
    share = f", {verdict.share:.0%} of the strength of all directions" if verdict.share else ""
    table.add_row("verdict", f"[bold]{ARROW.get(way, '')} {way.value}[/bold]{share}")
    return table


def _told_steps(verdict: Verdict) -> str:
    counts: Sequence[tuple[Direction, int]] = sorted(
        verdict.counts.items(), key=lambda item: -item[1]
    )
    parts = ", ".join(f"{count:,} {way.value}" for way, count in counts)
    return f"{verdict.steps:,}" + (f": {parts}" if parts else "")
