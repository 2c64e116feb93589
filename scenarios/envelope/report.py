"""The folder and the printed table of an envelope."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.table import Table

from scenarios.envelope.grid import BASE, NOISE, SPEED, Grid
from scenarios.envelope.maps import draw_comparison, draw_levels, draw_method
from scenarios.envelope.table import (
    CORRECT,
    MIN_CORRECT,
    NONE,
    OPPOSITE,
    Row,
    at_base_point,
    levels,
    mean_by_cell,
    operating_range,
)
from scenarios.output.atomic_folder import write_summary
from scenarios.output.streams import SafeConsole
from scenarios.output.tables import write_table
from scenarios.output.versions import versions
from scenarios.runs.run_table import format_percent
from scenarios.styles.method_style import method_style

TABLE = "envelope.csv"
_MAP_SUFFIXES = {CORRECT: "", OPPOSITE: "_opposite", NONE: "_none"}
"""Results that are drawn for each method, and the endings of the file names."""

Ranges = dict[str, list[float] | None]
"""Lowest and highest speed of the operating range [px/s] by noise [Hz]; None: no speed."""


def write_envelope(
    work: Path,
    rows: Sequence[Row],
    grid: Grid,
    arguments: dict[str, Any],
    failed: Mapping[str, str],
) -> None:
    """Write the table, the maps and the summary.

    Args:
        work: empty folder.
        rows: rows of `measure_all`.
        grid: the points that were measured.
        arguments: arguments of the command.
        failed: reasons of the methods that failed, by name.
    """
    write_table(work / TABLE, tuple(rows[0]), (tuple(row.values()) for row in rows))
    methods = levels(rows, "method")
    for method in methods:
        own = [row for row in rows if row["method"] == method]
        for value, suffix in _MAP_SUFFIXES.items():
            name = f"{method.replace(':', '.')}{suffix}"
            draw_method(work / name, own, value, crossed=grid.crossed)
    if len(methods) > 1:
        draw_comparison(work / "comparison", rows, crossed=grid.crossed)
    for factor in grid.crossed:
        draw_levels(work / f"by_{factor}", rows, factor)
    write_summary(
        work,
        {
            "command": "envelope",
            "parameters": arguments | {"out": str(arguments["out"])},
            "grid": asdict(grid),
            "base": asdict(BASE),
            "versions": versions(),
            "holds": {method: ranges_by_noise(rows, method) for method in methods},
            "failed": dict(failed),
        },
    )


def print_envelope(rows: Sequence[Row], grid: Grid) -> None:
    """Print correct steps by speed and noise, and the operating range, for every method."""
    console = SafeConsole()
    for method in levels(rows, "method"):
        own = [row for row in rows if row["method"] == method]
        full = at_base_point(own, (SPEED, NOISE, *grid.crossed))
        label = method_style(method).label
        title = f"{label}: correct steps after 100 ms in view"
        table = Table(title=title, title_justify="left")
        table.add_column("px/s", justify="right")
        for noise in levels(full, NOISE):
            table.add_column(f"{noise:g} Hz", justify="right")
        shares = mean_by_cell(full, SPEED, NOISE, CORRECT)
        for speed, column in zip(levels(full, SPEED), shares.T, strict=True):
            cells = (None if share != share else float(share) for share in column)
            table.add_row(f"{speed:g}", *(format_percent(cell) for cell in cells))
        console.print(table)
        ranges = _describe(ranges_by_noise(rows, method))
        console.print(
            f"{label}: at least {100 * MIN_CORRECT:.0f} % correct {ranges}", soft_wrap=True
        )


def ranges_by_noise(rows: Sequence[Row], method: str) -> Ranges:
    """Return the operating range of a method at every noise."""
    own = at_base_point([r for r in rows if r["method"] == method], (SPEED, NOISE, "direction"))
    ranges: Ranges = {}
    for noise in levels(own, NOISE):
        span = operating_range([row for row in own if row[NOISE] == noise])
        ranges[f"{noise:g}"] = None if span is None else list(span)
    return ranges


def _describe(ranges: Ranges) -> str:
    parts = [
        f"at {noise} Hz "
        + ("at no speed" if span is None else f"from {span[0]:g} to {span[1]:g} px/s")
        for noise, span in ranges.items()
    ]
    return "; ".join(parts)
