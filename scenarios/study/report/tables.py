"""The study's numbers as tables of a page: mean and 95 % interval, by method and condition."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape

from scenarios.study.figures.method_style import in_order, method_style
from scenarios.study.rows import Row
from scenarios.study.statistics import Interval, each, interval_of, select

NONE = "–"


@dataclass(frozen=True)
class _Column:
    """One figure: its column of the rows, its head, and by what it is multiplied."""

    name: str
    head: str
    scale: float = 1.0


_COLUMNS = (
    _Column("accuracy_after_100ms", "right steps after 100 ms [%]", 100.0),
    _Column("opposite_after_100ms", "opposite [%]", 100.0),
    _Column("sideways_after_100ms", "sideways [%]", 100.0),
    _Column("none_after_100ms", "none [%]", 100.0),
    _Column("accuracy", "right steps, all in view [%]", 100.0),
    _Column("latency_ms", "onset latency [ms]"),
    _Column("velocity_error_px_s", "velocity error, RMS [px/s]"),
    _Column("velocity_bias_px_s", "velocity bias [px/s]"),
    _Column("roi_iou", "ROI overlap, IoU [%]", 100.0),
    _Column("centroid_error_px", "view centre off by [px]"),
    _Column("grms", "GRMS [1/s]"),
    _Column("ms_per_estimate", "CPU time an estimate [ms]"),
    _Column("ns_per_event", "CPU time an event [ns]"),
)


def table_by_light(rows: Sequence[Row]) -> str:
    """A row a light and method, over all its velocities."""
    return _table(rows, "lighting", str)


def table_by_sequence(rows: Sequence[Row]) -> str:
    """A row a sequence and method."""
    return _table(rows, "sequence", lambda name: f"{name.replace('_', ' ')} rad/s")


def _table(rows: Sequence[Row], column: str, name_of: Callable[[str], str]) -> str:
    shown = [c for c in _COLUMNS if any(row[c.name] is not None for row in rows)]
    heads = "".join(f"<th>{escape(h)}</th>" for h in ("method", "verdict right"))
    heads += "".join(f"<th>{escape(c.head)}</th>" for c in shown)
    lines = []
    for level in each(rows, column):
        for method in in_order(each(rows, "method")):
            if own := select(rows, method=method, **{column: level}):
                where = f'<span class="small">{escape(name_of(level))}</span>'
                first = f"<th>{escape(method_style(method).label)}<br>{where}</th>"
                lines.append(f"<tr>{first}{_cells(own, shown)}</tr>")
    body = "\n".join(lines)
    return (
        f'<div class="wide" tabindex="0"><table class="numbers"><thead><tr>{heads}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody></table></div>"
    )


def _cells(rows: Sequence[Row], columns: Sequence[_Column]) -> str:
    right = sum(row["verdict"] == row["truth"] for row in rows)
    told = [f"{right} of {len(rows)}", *(_interval(rows, column) for column in columns)]
    return "".join(f'<td class="number">{text}</td>' for text in told)


def _interval(rows: Sequence[Row], column: _Column) -> str:
    found = interval_of(rows, column.name)
    if found is None:
        return NONE
    known = sum(row[column.name] is not None for row in rows)
    part = f"<br>{known} of {len(rows)}" if known < len(rows) else ""
    return f"{number(column.scale * found.mean)}{_span(found, column.scale)}{part}"


def _span(found: Interval, scale: float) -> str:
    if found.number == 1:
        return ""
    low, high = number(scale * found.low), number(scale * found.high)
    return f'<br><span class="small">{low} to {high}</span>'


def number(value: float) -> str:
    """A number to three digits as people read it, without a power of ten."""
    if value == 0 or abs(value) < 1e-9:
        return "0"
    text = f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
    return text.replace(",", "\u202f").replace("-", "−")
