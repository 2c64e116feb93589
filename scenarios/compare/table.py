"""The table of `flybench compare`."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from formats import EventFile
from scenarios.compare.compared import Compared, Unit, busiest_shared
from scenarios.event_statistics.recording_statistics import RecordingStatistics
from scenarios.output.numbers import counted

ABSENT = "–"
_DECIMALS = {Unit.EVENTS: 2, Unit.LOG: 2}


def print_comparison(
    console: Console,
    files: tuple[EventFile, EventFile],
    statistics: tuple[RecordingStatistics, RecordingStatistics],
    rows: Sequence[Compared],
) -> None:
    """Print what A and B are, and every statistic with its distance.

    Args:
        console: where to print.
        files: the recordings, read to their ends.
        statistics: their statistics.
        rows: the compared statistics.
    """
    for letter, file, found in zip("AB", files, statistics, strict=True):
        text = f"{letter}: {file.path}, {_summary(file, found)}"
        console.print(text, soft_wrap=True)
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for head in ("statistic", "A", "B", "distance", "measure"):
        table.add_column(head, justify="left" if head in ("statistic", "measure") else "right")
    for row in rows:
        distance = ABSENT if row.distance is None else f"{row.distance:.2f}"
        cells = (format_value(row.a, row.unit), format_value(row.b, row.unit), distance)
        table.add_row(row.name, *cells, str(row.measure))
    console.print(table)
    for note in notes(statistics):
        console.print(note, soft_wrap=True)


def format_value(value: float | None, unit: Unit) -> str:
    """Return a value with its unit, as the table shows it."""
    if value is None:
        return "" if unit is Unit.NONE else ABSENT
    if unit is Unit.SHARE:
        return f"{100 * value:.1f} %"
    if unit in _DECIMALS:
        return f"{value:.{_DECIMALS[unit]}f}"
    return f"{value:,.0f} {unit}" if value >= 100 else f"{value:.3g} {unit}"


def notes(statistics: tuple[RecordingStatistics, RecordingStatistics]) -> list[str]:
    """Return what the recordings could not tell, one sentence each."""
    found = []
    for letter, recording in zip("AB", statistics, strict=True):
        if not recording.frames:
            found.append(f"{letter} has no APS frames: its noise is not split by brightness.")
    shared = busiest_shared(*statistics)
    if shared is None:
        found.append("The order of rows is not compared: no event rate lasts long enough in both.")
    else:
        load = shared[0].from_mev_s
        found.append(f"The order of rows is compared in milliseconds from {load:g} Mev/s on.")
    return found


def _summary(file: EventFile, found: RecordingStatistics) -> str:
    rate_mev_s = found.events / found.span_us
    parts = [
        f"{counted(found.events, 'event')} in {found.span_us * 1e-6:,.3f} s "
        f"({rate_mev_s:.3g} Mev/s)",
        counted(found.frames, "frame"),
        f"{100 * found.quiet_share:.0f} % of pixels quiet",
    ]
    if file.sorted_events is not None:
        parts.append(f"{counted(file.sorted_events, 'late event')} sorted")
    if file.dropped_events is not None:
        parts.append(f"{counted(file.dropped_events, 'event')} out of order dropped")
    return ", ".join(parts)
