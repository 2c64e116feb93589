"""Tables of the study's numbers: mean and 95 % interval, by method and condition."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from scenarios.output.numbers import plain_number
from scenarios.study.rows import Row
from scenarios.study.statistics import distinct, interval_of, select
from scenarios.styles.method_style import in_display_order, method_style

NO_VALUE = "–"


@dataclass(frozen=True)
class _Column:
    """One column: name in the rows, heading, and factor to its unit."""

    name: str
    heading: str
    scale: float = 1.0


_CORRECT = _Column("accuracy_after_100ms", "correct steps after 100 ms [%]", 100.0)
_COLUMNS = (
    _CORRECT,
    _Column("opposite_after_100ms", "opposite [%]", 100.0),
    _Column("sideways_after_100ms", "sideways [%]", 100.0),
    _Column("none_after_100ms", "no decision [%]", 100.0),
    _Column("accuracy", "correct steps, all in view [%]", 100.0),
    _Column("latency_ms", "onset latency [ms]"),
    _Column("velocity_error_px_s", "velocity error, RMS [px/s]"),
    _Column("velocity_bias_px_s", "velocity bias [px/s]"),
    _Column("roi_iou", "ROI overlap, IoU [%]", 100.0),
    _Column("centroid_error_px", "view centre error [px]"),
    _Column("grms", "GRMS [1/s]"),
    _Column("ms_per_estimate", "CPU time per estimate [ms]"),
    _Column("ns_per_event", "CPU time per event [ns]"),
)


@dataclass(frozen=True)
class Cell:
    """One number as text.

    Attributes:
        mean: mean over the seeds.
        interval: its 95 % interval; empty for a single seed.
        runs: number of runs with a value; empty if all have one.
    """

    mean: str
    interval: str = ""
    runs: str = ""


@dataclass(frozen=True)
class TableRow:
    """The numbers of one method in one condition."""

    method: str
    condition: str
    cells: Sequence[Cell]


@dataclass(frozen=True)
class Table:
    """A table: headings of all columns, and rows."""

    headings: Sequence[str]
    rows: Sequence[TableRow]


def table_by_lighting(rows: Sequence[Row]) -> Table:
    """Return a table with a row for each lighting and method, over all velocities."""
    return _table(rows, "lighting", str)


def table_by_sequence(rows: Sequence[Row]) -> Table:
    """Return a table with a row for each sequence and method."""
    return _table(rows, "sequence", lambda name: f"{name.replace('_', ' ')} rad/s")


def table_by_background(rows: Sequence[Row]) -> Table:
    """Return a table of correct steps, with a row for each lighting and method.

    Args:
        rows: rows of the sequences with a moving background, which are the columns.
    """
    backgrounds = distinct(rows, "background")
    headings = ["method", *(f"{name}: correct steps [%]" for name in backgrounds)]
    lines = [
        TableRow(
            method_style(method).label,
            lighting,
            [_cell(select(own, background=name), _CORRECT) for name in backgrounds],
        )
        for lighting in distinct(rows, "lighting")
        for method in in_display_order(distinct(rows, "method"))
        if (own := select(rows, method=method, lighting=lighting))
    ]
    return Table(headings, lines)


def table_by_sensor(rows: Sequence[Row], other: Sequence[Row]) -> Table:
    """Return a table that compares two sensors, with a row for each method.

    Args:
        rows: rows of the paper's sequences, seen by the default sensor.
        other: the same sequences, seen by the other sensor.
    """
    lightings = distinct(rows, "lighting")
    parts = [(own, lighting) for lighting in lightings for own in (rows, other)]
    names = ("default", "high thresholds")
    headings = [
        "method",
        *(f"{lighting}, {name}: correct steps [%]" for lighting in lightings for name in names),
    ]
    lines = [
        TableRow(
            method_style(method).label,
            "",
            [_cell(select(own, method=method, lighting=at), _CORRECT) for own, at in parts],
        )
        for method in in_display_order(distinct(other, "method"))
    ]
    return Table(headings, lines)


def _table(rows: Sequence[Row], column: str, name_of: Callable[[str], str]) -> Table:
    shown = [c for c in _COLUMNS if any(row[c.name] is not None for row in rows)]
    headings = ["method", "correct verdicts", *(c.heading for c in shown)]
    lines = [
        TableRow(method_style(method).label, name_of(level), _cells(own, shown))
        for level in distinct(rows, column)
        for method in in_display_order(distinct(rows, "method"))
        if (own := select(rows, method=method, **{column: level}))
    ]
    return Table(headings, lines)


def _cells(rows: Sequence[Row], columns: Sequence[_Column]) -> list[Cell]:
    correct = sum(row["verdict"] == row["truth"] for row in rows)
    return [Cell(f"{correct} of {len(rows)}"), *(_cell(rows, column) for column in columns)]


def _cell(rows: Sequence[Row], column: _Column) -> Cell:
    found = interval_of(rows, column.name)
    if found is None:
        return Cell(NO_VALUE)
    mean, low, high = (plain_number(column.scale * x) for x in (found.mean, found.low, found.high))
    known = sum(row[column.name] is not None for row in rows)
    return Cell(
        mean,
        f"{low} to {high}" if found.number > 1 else "",
        f"{known} of {len(rows)}" if known < len(rows) else "",
    )
