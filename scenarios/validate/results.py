"""Results of all windows, and their table as CSV and on the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from flybench.direction import Direction
from scenarios.detect.verdict import percent
from scenarios.errors import MethodError
from scenarios.output.tables import write_table
from scenarios.recording.entities import ARROW
from scenarios.styles.method_style import method_style
from scenarios.validate.manifest import Recording, Window
from scenarios.validate.scoring import Score, Total
from scenarios.validate.turns import TURNS, Turn

COLUMNS = (
    "recording",
    "window",
    "from_s",
    "to_s",
    "crop",
    "variant",
    "truth",
    "method",
    "steps",
    "right",
    "wrong",
    "none",
    "first_right_ms",
    "false_alarms",
    "verdict",
    "note",
    "failed",
)
HEAD = ("method", "right", "wrong", "none", "first right", "verdicts")
STILL_HEAD = ("method", "right", "false alarms", "verdicts")
"""Columns of a table of windows with motion, and without."""


@dataclass(frozen=True, eq=False)
class WindowResult:
    """Scores of all methods in one window.

    Attributes:
        recording: the recording.
        number: number of the window in the recording, from 1.
        window: the window.
        duration_us: its duration [µs].
        images: times [µs] and addresses of its event images.
        scores: scores by method, and by variant of the window.
    """

    recording: Recording
    number: int
    window: Window
    duration_us: int
    images: Sequence[tuple[int, str]]
    scores: dict[str, dict[Turn, Score]]

    @property
    def moves(self) -> bool:
        """True if something moves in the window."""
        return self.window.direction is not Direction.NONE

    @property
    def totals(self) -> dict[str, Total]:
        """Sum over the variants, by method."""
        return {method: Total.of(s.values()) for method, s in self.scores.items()}

    @property
    def label(self) -> str:
        """Recording, times and true direction."""
        start_us, truth = self.window.from_us, self.window.direction
        end_us = start_us + self.duration_us
        what = f"{ARROW[truth]} {truth.value}" if truth in ARROW else "nothing moves"
        return f"{self.recording.name}, {start_us * 1e-6:.2f} to {end_us * 1e-6:.2f} s: {what}"


def failures(results: Sequence[WindowResult]) -> list[str]:
    """Return one line for each window and method that failed in a variant, with the first reason.

    Raises:
        MethodError: no score is complete, and a method failed.
    """
    lines = []
    for result in results:
        for method, by_turn in result.scores.items():
            reasons = [score.failed for score in by_turn.values() if score.failed]
            if reasons:
                place = f"{result.recording.name}, window {result.number}"
                count = f"{len(reasons)} of {len(by_turn)} variants"
                lines.append(f"{place}, {count}: {method}: {reasons[0]}")
    scores = [s for r in results for by_turn in r.scores.values() for s in by_turn.values()]
    if lines and all(score.note or score.failed for score in scores):
        raise MethodError(f"No method ran to the end of a window. {lines[0]}")
    return lines


def totals(results: Sequence[WindowResult], *, moving: bool) -> dict[str, Total]:
    """Return the sum by method over all windows with motion, or without; empty if there is none."""
    chosen = [result for result in results if result.moves is moving]
    methods = chosen[0].scores if chosen else ()
    return {m: Total.of(s for r in chosen for s in r.scores[m].values()) for m in methods}


def head(*, moving: bool) -> tuple[str, ...]:
    """Return the columns of a table of windows with motion, or without."""
    return HEAD if moving else STILL_HEAD


def cells(total: Total, *, moving: bool) -> tuple[str, ...]:
    """Return the cells of a row below `head`, without the method; "–" where nothing counts."""
    right, verdicts = _percent(total.right), _verdicts(total)
    if not moving:
        return right, _percent(total.false_alarms), verdicts
    first = "–" if total.first_right_us is None else f"{total.first_right_us / 1e3:.0f} ms"
    return right, _percent(total.wrong), _percent(total.none), first, verdicts


def _verdicts(total: Total) -> str:
    parts = [f"{total.right_verdicts} of {total.verdicts}"] if total.verdicts else []
    parts += [f"{total.too_short} too short"] if total.too_short else []
    return ", ".join(parts) or "–"


def _percent(share: float | None) -> str:
    return "–" if share is None else percent(share)


def write_csv(path: Path, results: Sequence[WindowResult]) -> None:
    """Write one row for each window, variant and method."""
    write_table(path, COLUMNS, (row for result in results for row in _rows(result)))


def _rows(result: WindowResult) -> Iterator[Sequence[Any]]:
    window = result.window
    from_s = window.from_us * 1e-6
    crop = "" if window.crop is None else " ".join(map(str, window.crop))
    times = (f"{from_s:.6f}", f"{from_s + result.duration_us * 1e-6:.6f}")
    for turn in TURNS:
        for method, by_turn in result.scores.items():
            s = by_turn[turn]
            first_ms = None if s.first_right_us is None else s.first_right_us / 1e3
            yield (
                *(result.recording.name, result.number, *times, crop, turn.name, s.truth.value),
                *(method, s.steps, s.right, s.wrong, s.none, first_ms, s.false_alarms),
                *(s.verdict, s.note, s.failed),
            )


def print_results(console: Console, results: Sequence[WindowResult]) -> None:
    """Print a table for each window, and one for all windows with motion and without.

    The sums over windows leave out those in which a method could not run, or failed.
    """
    for result in results:
        _print_table(console, result.label, result.totals, moving=result.moves)
    for moving, title in ((True, "with"), (False, "without")):
        by_method = totals(results, moving=moving)
        if by_method:
            _print_table(console, f"all windows {title} motion", by_method, moving=moving)


def _print_table(
    console: Console, title: str, by_method: dict[str, Total], *, moving: bool
) -> None:
    table = Table(title=title, title_justify="left", title_style="bold", box=None)
    for name in head(moving=moving):
        table.add_column(name, justify="left" if name == "method" else "right")
    for method, total in by_method.items():
        table.add_row(method_style(method).label, *cells(total, moving=moving))
    console.print(table)
    for note in dict.fromkeys(total.note for total in by_method.values() if total.note):
        methods = "; ".join(  # a label may contain a comma
            method_style(method).label for method, total in by_method.items() if total.note == note
        )
        console.print(f"{methods}: {note}", markup=False)
    console.print()
