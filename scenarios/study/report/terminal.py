"""The results of the study as a table in the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from scenarios.output.streams import SafeConsole
from scenarios.runs.run_table import format_three_digits
from scenarios.study.claims.claim import Claim, format_interval
from scenarios.study.rows import Row
from scenarios.study.statistics import Interval, by_method_and_lighting
from scenarios.styles.method_style import method_style

_HEADINGS = (
    "method",
    "lighting",
    "correct after 100 ms",
    "latency",
    "CPU ms per estimate",
    "CPU ns per event",
)


def print_study(rows: Sequence[Row], claims: Sequence[Claim]) -> None:
    """Print the results of each method in each lighting, and the verdict on each claim."""
    table = Table(*_HEADINGS, title="study", title_justify="left")
    table.columns[0].no_wrap = True
    for method, by_lighting in by_method_and_lighting(rows).items():
        for lighting, found in by_lighting.items():
            latency = found["latency_ms"]
            table.add_row(
                method_style(method).label,
                lighting,
                format_interval(found["accuracy_after_100ms"], "%"),
                "–" if latency is None else f"{latency.mean:.0f} ms",
                *(
                    format_three_digits(_mean(found[name]))
                    for name in ("ms_per_estimate", "ns_per_event")
                ),
            )
    console = SafeConsole()
    console.print(table)
    for claim in claims:
        console.print(f"{claim.holds}: {claim.statement}", soft_wrap=True, highlight=False)


def _mean(interval: Interval | None) -> float | None:
    return None if interval is None else interval.mean
