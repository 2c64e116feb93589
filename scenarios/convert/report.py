"""Tables and notes about a conversion."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path

from rich.table import Table

from formats import EventFile
from scenarios.convert.copying import Totals
from scenarios.detect.estimate_output import file_rows
from scenarios.output.streams import SafeConsole, complain

_KINDS = ("events", "frames", "IMU samples", "triggers")
"""Names of the fields of `Counts`."""


def print_conversion(file: EventFile, out: Path, totals: Totals) -> None:
    """Print what was read and what was written; on standard error, what was lost and why."""
    console = SafeConsole()
    source = Table(title=str(file.path), title_justify="left", show_header=False)
    for name, value in file_rows(file):
        source.add_row(name, value)
    for name, value in file.header_fields.items():
        source.add_row(f"header: {name}", value)
    console.print(source)
    console.print(_counts_table(out, totals))
    lost = zip(_KINDS, astuple(totals.unsupported), strict=True)
    listed = " and ".join(f"{count:,} {kind}" for kind, count in lost if count)
    if listed:
        reason = "The new format has no place for them, or they come before the first event."
        complain(f"note: {listed} were not written. {reason}")
    if totals.damage:
        complain(f"warning: {totals.damage}")


def _counts_table(out: Path, totals: Totals) -> Table:
    table = Table(title=str(out), title_justify="left")
    columns = {
        "read": totals.read,
        "outside the time": totals.outside_time,
        "outside the crop": totals.outside_crop,
        "written": totals.written,
    }
    counts = {name: astuple(column) for name, column in columns.items()}
    shown = [name for name, values in counts.items() if name in ("read", "written") or any(values)]
    table.add_column("")
    for name in shown:
        table.add_column(name, justify="right")
    for row, kind in enumerate(_KINDS):
        if counts["read"][row] or kind == "events":
            table.add_row(kind, *(f"{counts[name][row]:,}" for name in shown))
    return table
