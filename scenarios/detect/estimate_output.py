"""Print estimates while a recording is read: as a table on the terminal, or as JSON."""

from __future__ import annotations

import json
import shutil
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import IO, Any, Self, TextIO

from rich.console import Console
from rich.table import Table
from rich.text import Text

from detector.estimate import MotionEstimate
from flybench.direction import Direction
from formats import EventFile
from scenarios.detect.spans import Span
from scenarios.detect.verdict import RecordingVerdict
from scenarios.output.numbers import counted
from scenarios.recording.entities import ARROW
from scenarios.styles.method_style import method_style

PAGE_ROWS = 50
"""Rows of the table that are printed at a time."""
MOST_SPANS = 8
"""Most spans of one direction in the summary (assumed: three lines of a terminal)."""
_COLUMNS = (("time [s]", 13), ("HS", 7), ("VS", 7), ("direction", 10), ("strength", 9))


@dataclass(frozen=True, eq=False)
class Outcome:
    """A recording that was read, and the result of the detector on it.

    Attributes:
        file: the recording, read to its end or to an error.
        method: name of the detector.
        scaled: parameters of the detector that were scaled, by name.
        verdict: verdict over all estimates.
        failure: reason why the detector failed; None if it did not.
        error: reason why the file could not be read to its end; None if it could.
    """

    file: EventFile
    method: str
    scaled: Mapping[str, Any]
    verdict: RecordingVerdict
    failure: str | None
    error: str | None


class EstimatePrinter(ABC):
    """Prints estimates as they come, then a summary; use it as a context manager."""

    def __enter__(self) -> Self:
        return self

    @abstractmethod
    def __exit__(self, *_: object) -> None:
        """Release all resources."""

    @abstractmethod
    def add(self, estimate: MotionEstimate) -> None:
        """Print or store an estimate."""

    @abstractmethod
    def finish(self, outcome: Outcome) -> None:
        """Print the rest and the summary."""


class EstimateTable(EstimatePrinter):
    """Prints a table page by page while the recording is read."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._pending: list[MotionEstimate] = []
        self._has_header = False

    def __exit__(self, *_: object) -> None:
        self._flush()

    def add(self, estimate: MotionEstimate) -> None:
        """Add a row, and print the page if it is full."""
        self._pending.append(estimate)
        if len(self._pending) >= PAGE_ROWS:
            self._flush()

    def finish(self, outcome: Outcome) -> None:
        """Print the last page and a summary table."""
        self._flush()
        self._console.print(_summary_table(outcome))

    def _flush(self) -> None:
        if not self._pending:
            return
        table = Table(box=None, show_header=not self._has_header, pad_edge=False)
        for name, width in _COLUMNS:
            justify: Any = "left" if name == "direction" else "right"
            table.add_column(name, justify=justify, width=width)
        for e in self._pending:
            direction = f"{ARROW.get(e.direction, ' ')} {e.direction.value}"
            table.add_row(
                f"{e.t_us * 1e-6:.3f}",
                f"{e.hs:+.3f}",
                f"{e.vs:+.3f}",
                direction,
                f"{e.strength:.3f}",
                style="dim" if e.direction is Direction.NONE else None,
            )
        self._console.print(table)
        self._has_header, self._pending = True, []


class EstimateJson(EstimatePrinter):
    """Prints one JSON document at the end; estimates are kept in a temporary file until then."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._file: IO[str] = tempfile.TemporaryFile(  # noqa: SIM115  (closed on exit)
            "w+", encoding="utf-8"
        )
        self._file.write('{"steps": [')
        self._separator = "\n"

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def add(self, estimate: MotionEstimate) -> None:
        """Add an estimate to the document."""
        self._file.write(self._separator + json.dumps(_estimate_json(estimate)))
        self._separator = ",\n"

    def finish(self, outcome: Outcome) -> None:
        """Complete the document and print it."""
        tail = {
            **outcome.verdict.to_json(),
            "method": outcome.method,
            "failed": outcome.failure,
            "error": outcome.error,
            "scaled": dict(outcome.scaled),
            "file": {"name": str(outcome.file.path), **_file_json(outcome.file)},
        }
        self._file.write("\n], " + json.dumps(tail)[1:] + "\n")
        self._file.seek(0)
        shutil.copyfileobj(self._file, self._stream)
        self._stream.flush()


def _estimate_json(estimate: MotionEstimate) -> dict[str, Any]:
    e = estimate
    return {
        "t_us": e.t_us,
        "hs": e.hs,
        "vs": e.vs,
        "direction": e.direction.value,
        "strength": e.strength,
    }


def _file_json(file: EventFile) -> dict[str, Any]:
    found = file.statistics
    return {
        "format": file.format,
        "width": file.width,
        "height": file.height,
        "size_source": file.size_source,
        "header": file.header_fields,
        "origin_us": file.origin_us,
        "events": found.events,
        "first_us": found.first_us,
        "last_us": found.last_us,
        "rate_hz": found.rate_hz,
        "on_share": found.on_share,
        "frames": found.frames,
        "imu": found.imu,
        "triggers": found.triggers,
        "sorted_events": file.sorted_events,
        "dropped_events": file.dropped_events,
        "warnings": list(file.warnings),
    }


def file_line(file: EventFile) -> str:
    """Return one line about a file that was just opened: format, sensor and unit of time."""
    unit = file.header_fields["time unit"]
    return f"{file.format}, {_sensor(file)}, times in {unit}"


def _polarities(on_share: float) -> str:
    return f"{100 * on_share:.1f} %, {100 * (1 - on_share):.1f} %"


def _sensor(file: EventFile) -> str:
    return f"{file.width} × {file.height} px, from {file.size_source}"


def file_rows(file: EventFile) -> list[tuple[str, str]]:
    """Return the rows of the summary table about the file."""
    found = file.statistics
    rows = [
        ("format", file.format),
        ("sensor", _sensor(file)),
        ("events", f"{found.events:,} in {found.span_us * 1e-6:,.3f} s"),
        ("time", f"{found.first_us * 1e-6:,.6f} s to {found.last_us * 1e-6:,.6f} s"),
        ("rate", f"{found.rate_hz * 1e-3:,.1f} kev/s"),
        ("ON, OFF", _polarities(found.on_share) if found.events else "none"),
        ("x, y", f"{found.x_min} to {found.x_max}, {found.y_min} to {found.y_max}"),
        ("frames", f"{found.frames:,}"),
    ]
    if found.imu or found.triggers:
        rows.append(("IMU, triggers", f"{counted(found.imu, 'sample')}, {found.triggers:,}"))
    if file.origin_us:
        rows.insert(4, ("time origin", f"{file.origin_us:,} µs in the file"))
    if file.sorted_events is not None:
        rows.append(("sorted", counted(file.sorted_events, "late event")))
    if file.dropped_events is not None:
        rows.append(("dropped", f"{counted(file.dropped_events, 'event')} out of order"))
    return rows


def _summary_table(outcome: Outcome) -> Table:
    file, verdict = outcome.file, outcome.verdict
    table = Table(title=str(file.path), title_justify="left", show_header=False)
    for name, value in file_rows(file):
        table.add_row(name, value)
    for name, value in file.header_fields.items():
        table.add_row(f"header: {name}", value)
    table.add_section()
    table.add_row("method", method_style(outcome.method).label)
    if outcome.scaled:
        scaled = ", ".join(f"{name} = {value}" for name, value in outcome.scaled.items())
        table.add_row("scaled", scaled)
    if outcome.failure:
        table.add_row("failed", outcome.failure)
    if outcome.error:
        table.add_row("error", f"This is what was read before: {outcome.error}")
    table.add_row("all steps", verdict.shares_text)
    table.add_row("spans", _spans(verdict))
    word = f"{ARROW.get(verdict.direction, '')} {verdict.word}".lstrip()
    table.add_row("verdict", Text.assemble((word, "bold"), f": {verdict.reason}"))
    return table


def _spans(verdict: RecordingVerdict) -> str:
    spans = verdict.spans
    parts = [f"{s.direction.value} {_seconds(s)}" for s in spans[:MOST_SPANS]]
    if len(spans) > MOST_SPANS:
        parts.append(f"and {len(spans) - MOST_SPANS:,} more, which --json lists")
    return ", ".join(parts) or "none"


def _seconds(span: Span) -> str:
    return f"{span.from_us * 1e-6:.2f} to {span.to_us * 1e-6:.2f} s"
