"""The table of a velocity sweep in the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean

from rich.table import Table

from scenarios.output.streams import SafeConsole
from scenarios.runs.run_table import (
    format_overlap,
    format_percent,
    format_pixels,
    format_three_digits,
)
from scenarios.styles.method_style import method_style
from scenarios.velocity_sweep.rows import Row

COLUMNS = (
    "rad/s",
    "px/s",
    "verdict",
    "correct\nsteps",
    "after\n100 ms",
    "first\ncorrect",
    "IoU",
    "centre\nerror",
    "GRMS\n[1/s]",
)


def print_rows(rows: Sequence[Row]) -> None:
    """Print one table per lighting, with one line per velocity: the means over the seeds."""
    seeds = len({row["seed"] for row in rows})
    for lighting in dict.fromkeys(row["lighting"] for row in rows):
        own = [row for row in rows if row["lighting"] == lighting]
        method = method_style(own[0]["method"]).label
        title = f"{lighting}, moving {own[0]['truth']}, {method}, seeds: {seeds}"
        table = Table(title=title, title_justify="left", pad_edge=False)  # fits into 80 columns
        for name in COLUMNS:
            table.add_column(name, no_wrap=name != "verdict")
        for omega in dict.fromkeys(row["omega_rad_s"] for row in own):
            table.add_row(*_cells([row for row in own if row["omega_rad_s"] == omega]))
        SafeConsole().print(table)


def _cells(rows: Sequence[Row]) -> tuple[str, ...]:
    def mean(name: str) -> float | None:
        values = [row[name] for row in rows if row[name] is not None]
        return fmean(values) if values else None

    first, latency = rows[0], mean("latency_ms")
    verdicts = sorted({row["direction"] for row in rows})
    return (
        f"{first['omega_rad_s']:.2f}",
        f"{first['image_speed_px_s']:.0f}",
        " or ".join(verdicts),
        format_percent(mean("accuracy")),
        format_percent(mean("accuracy_after_100ms")),
        "never" if latency is None else f"{latency:.0f} ms",
        format_overlap(mean("roi_iou")),
        format_pixels(mean("centroid_error_px")),
        format_three_digits(mean("grms")),
    )
