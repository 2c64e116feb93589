"""Accuracy against ground truth, by method and sequence; the paper has no such figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from scenarios.output.figures import figure_file
from scenarios.study.figures.sequence_axis import (
    add_legend,
    label_sequences,
    methods_of,
)
from scenarios.study.results import SequenceResult
from scenarios.study.rows import Row, study_rows
from scenarios.study.statistics import mean_interval
from scenarios.styles.lighting_style import lighting_style
from scenarios.styles.method_style import method_style

WIDTH_IN = 7.8
_PANEL_IN = 1.62
_DODGE = 0.7
"""Share of a sequence's width over which the methods are spread, so that none hides another."""
_LOAD = "load"


@dataclass(frozen=True)
class _Panel:
    """One panel: a column of the table, its title, unit and scale."""

    column: str
    title: str
    unit: str
    is_share: bool = False
    is_log: bool = False


_PANELS = (
    _Panel(
        "accuracy_after_100ms", "correct steps after 100 ms in view", "steps [%]", is_share=True
    ),
    _Panel(
        "latency_ms",
        "onset latency: from the first pixel in view to the first correct step",
        "[ms]",
        is_log=True,
    ),
    _Panel("velocity_error_px_s", "velocity error, root mean square", "[px/s]"),
    _Panel("roi_iou", "overlap of region of interest and true box", "IoU [%]", is_share=True),
    _Panel(_LOAD, "CPU time per second of the stream", "[s]", is_log=True),
)


def draw_truth(path: Path, sequences: Sequence[SequenceResult]) -> None:
    """Draw a panel for each quantity: mean over the seeds and 95 % interval, by sequence.

    A quantity that no method has gets no panel. If only some seeds have a value, their number is
    printed at the point. If no seed has one, such as a latency where no step was correct, a cross
    is drawn at the top.

    Args:
        path: path of the figure, without a suffix.
        sequences: one result or more, by day, at night or both.
    """
    seconds = {one.name: one.duration_us / 1e6 for one in sequences}
    rows = [row | {_LOAD: row["cpu_s"] / seconds[row["sequence"]]} for row in study_rows(sequences)]
    panels = [panel for panel in _PANELS if any(row[panel.column] is not None for row in rows)]
    with figure_file(path, (WIDTH_IN, 0.9 + _PANEL_IN * len(panels))) as figure:
        grid = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
        for letter, axes, panel in zip("ABCDE", grid, panels, strict=False):
            _draw_panel(axes, panel, sequences, rows)
            axes.set_title(f"{letter}\u2002{panel.title}", fontsize=9)
            axes.tick_params(axis="x", which="both", labelbottom=axes is grid[-1])
        add_legend(figure, sequences, _legend_entries(rows, panels))


def _draw_panel(
    axes: Axes, panel: _Panel, sequences: Sequence[SequenceResult], rows: Sequence[Row]
) -> None:
    methods = methods_of(sequences)
    measured = {row["method"] for row in rows if row[panel.column] is not None}
    offsets = np.linspace(-_DODGE / 2, _DODGE / 2, 2 * len(methods) + 1)[1::2]
    for column, sequence in enumerate(sequences):
        for method, offset in zip(methods, offsets, strict=True):
            values = [
                row[panel.column]
                for row in rows
                if row["sequence"] == sequence.name and row["method"] == method
                if method in measured
            ]
            _draw_point(axes, column + float(offset), values, method, sequence.lighting, panel)
    label_sequences(axes, sequences)
    for number, (before, after) in enumerate(pairwise(sequences)):
        changes = before.lighting != after.lighting
        axes.axvline(number + 0.5, color="#80868e" if changes else "#e3e6ea", linewidth=0.7)
    _scale(axes, panel)
    if panel.is_log:  # an interval may extend below zero
        known = [row[panel.column] for row in rows if row[panel.column]]
        axes.set_ylim(bottom=min(known) / 2, top=2 * axes.get_ylim()[1])


def _draw_point(
    axes: Axes,
    at: float,
    values: Sequence[float | None],
    method: str,
    lighting: str,
    panel: _Panel,
) -> None:
    style, known = method_style(method), [value for value in values if value is not None]
    found = mean_interval(known, is_share=panel.is_share)
    if found is None:
        if values:  # the method has a value in another sequence
            axes.plot([at], [0.94], transform=axes.get_xaxis_transform(), **_cross(style.colour))
        return
    scale = 100.0 if panel.is_share else 1.0
    line = lighting_style(lighting, style.colour) | {"linestyle": "none", "markersize": 5.5}
    axes.plot([at, at], [scale * found.low, scale * found.high], color=style.colour, linewidth=1.4)
    axes.plot([at], [scale * found.mean], marker=style.marker, **line)
    if len(known) < len(values):
        axes.annotate(
            f"{len(known)}/{len(values)}",
            (at, scale * found.mean),
            xytext=(0, 6),
            textcoords="offset points",
            ha="center",
            fontsize=6,
        )


def _scale(axes: Axes, panel: _Panel) -> None:
    axes.set_ylabel(panel.unit, fontsize=8)
    axes.tick_params(axis="y", labelsize=8)
    axes.margins(y=0.12)
    if panel.is_share:
        axes.set(ylim=(-6, 106), yticks=(0, 50, 100))
    elif panel.is_log:
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.yaxis.set_minor_formatter(NullFormatter())
    else:
        axes.set_ylim(bottom=-0.07 * axes.get_ylim()[1])
    if panel.column == _LOAD:
        axes.axhline(1.0, color="black", linestyle=":", linewidth=1.0)


def _legend_entries(rows: Sequence[Row], panels: Sequence[_Panel]) -> list[Line2D]:
    dotted = Line2D([], [], color="black", linestyle=":", linewidth=1.0, label="real time")
    found = {
        (panel.column, row["sequence"], row["method"])
        for panel in panels
        for row in rows
        if row[panel.column] is not None
    }
    measured = {(column, method) for column, _, method in found}
    tried = {
        (column, row["sequence"], method)
        for row in rows
        for column, method in measured
        if row["method"] == method
    }
    missing = Line2D([], [], label="no value", **_cross("#4a5058"))
    return [dotted, missing] if tried - found else [dotted]


def _cross(colour: str) -> dict[str, Any]:
    return {"color": colour, "marker": "x", "markersize": 6, "linestyle": "none", "mew": 1.6}
