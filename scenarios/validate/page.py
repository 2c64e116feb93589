"""The results as one self-contained HTML page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from scenarios.output.html import render
from scenarios.output.numbers import counted
from scenarios.styles.method_style import method_style
from scenarios.validate.manifest import Manifest, Recording
from scenarios.validate.results import WindowResult, cells, head, totals
from scenarios.validate.scoring import Score, Total
from scenarios.validate.turns import TURNS

_TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True)
class _Row:
    """One row of a table: a method, its cells, and why it could not run."""

    method: str
    cells: Sequence[str]
    note: str


@dataclass(frozen=True)
class _Table:
    """A table of scores."""

    columns: Sequence[str]
    rows: Sequence[_Row]


@dataclass(frozen=True)
class _Window:
    """One window: title, images with captions, its table, and the scores of each variant."""

    title: str
    conditions: str
    crop: str
    images: Sequence[tuple[str, str]]
    table: _Table
    variants: Sequence[tuple[str, Sequence[str]]]


@dataclass(frozen=True)
class _Section:
    """One recording and its windows."""

    recording: Recording
    windows: Sequence[_Window]


def render_page(
    manifest: Manifest, results: Sequence[WindowResult], *, versions: Mapping[str, str]
) -> str:
    """Render the page.

    Args:
        manifest: the manifest.
        results: results of all windows.
        versions: versions of the programs used, by name.
    """
    return render(
        "validation.html.j2",
        _TEMPLATES,
        title="Detectors on real recordings",
        manifest=manifest.path.name,
        programs=", ".join(f"{name} {number}" for name, number in versions.items()),
        turns=[turn.name for turn in TURNS],
        sums=list(_sums(results)),
        sections=[
            _Section(recording, [_window(result) for result in group])
            for recording, group in groupby(results, key=lambda result: result.recording)
        ],
    )


def _sums(results: Sequence[WindowResult]) -> Iterator[tuple[str, _Table]]:
    for moving, title in ((True, "Windows with motion"), (False, "Windows without motion")):
        by_method = totals(results, moving=moving)
        if by_method:
            yield title, _table(by_method, moving=moving)


def _window(result: WindowResult) -> _Window:
    crop = result.window.crop
    return _Window(
        title=result.label,
        conditions=result.window.conditions,
        crop="" if crop is None else f"x {crop[0]} to {crop[2]}, y {crop[1]} to {crop[3]} px",
        images=[(f"{end_us / 1e3:.0f} ms", png) for end_us, png in result.images],
        table=_table(result.totals, moving=result.moves),
        variants=[
            (method_style(method).label, [_variant(by_turn[turn]) for turn in TURNS])
            for method, by_turn in result.scores.items()
        ],
    )


def _table(by_method: Mapping[str, Total], *, moving: bool) -> _Table:
    rows = [
        _Row(method_style(method).label, cells(total, moving=moving), total.note)
        for method, total in by_method.items()
    ]
    return _Table(head(moving=moving), rows)


def _variant(score: Score) -> str:
    if score.note:
        return "–"
    if score.failed:
        return f"failed after {counted(score.steps, 'step')}"
    return f"{score.right} of {score.steps} right; {score.verdict}"
