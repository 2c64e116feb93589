"""What only truth can tell, by method and sequence; the paper has no counterpart of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from scenarios.output.figures import figure_file
from scenarios.study import results
from scenarios.study.figures.method_style import method_style
from scenarios.study.figures.sequence_axis import add_legend, light_line, methods_of, name_sequences
from scenarios.study.rows import Row, study_rows
from scenarios.study.statistics import mean_interval

WIDTH_IN = 7.8
_PANEL_IN = 1.62
_DODGE = 0.7
"""Share of a sequence's place over which the methods are spread, so that none hides another."""
_LOAD = "load"


@dataclass(frozen=True)
class _Panel:
    """One figure of the table: its column, what it is, its unit and scale."""

    column: str
    title: str
    unit: str
    is_share: bool = False
    is_log: bool = False


_PANELS = (
    _Panel("accuracy_after_100ms", "right steps, from 100 ms in view", "steps [%]", is_share=True),
    _Panel(
        "latency_ms",
        "onset latency: from the first pixel to the first right step",
        "[ms]",
        is_log=True,
    ),
    _Panel("velocity_error_px_s", "velocity error, root mean square", "[px/s]"),
    _Panel("roi_iou", "overlap of region of interest and true box", "IoU [%]", is_share=True),
    _Panel(_LOAD, "CPU time for a second of the stream", "[s]", is_log=True),
)


def draw_truth(path: Path, sequences: Sequence[results.Sequence]) -> None:
    """Draw a row a figure: its mean over the seeds and the 95 % interval, by method and sequence.

    A figure that no method has, has no row. Where some seeds lack it, such as the latency where no
    step was right, the point tells how many have it; where all do, a cross stands at the top.

    Args:
        path: of the figure, without a suffix.
        sequences: of both lights or of one, one at least.
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
        add_legend(figure, sequences, _notes(rows, panels))


def _draw_panel(
    axes: Axes, panel: _Panel, sequences: Sequence[results.Sequence], rows: Sequence[Row]
) -> None:
    methods = methods_of(sequences)
    able = {row["method"] for row in rows if row[panel.column] is not None}
    offsets = np.linspace(-_DODGE / 2, _DODGE / 2, 2 * len(methods) + 1)[1::2]
    for column, sequence in enumerate(sequences):
        for method, offset in zip(methods, offsets, strict=True):
            values = [
                row[panel.column]
                for row in rows
                if row["sequence"] == sequence.name and row["method"] == method in able
            ]
            _draw_point(axes, column + float(offset), values, method, sequence.lighting, panel)
    name_sequences(axes, sequences)
    for number, (before, after) in enumerate(pairwise(sequences)):
        is_other = before.lighting != after.lighting
        axes.axvline(number + 0.5, color="#80868e" if is_other else "#e3e6ea", linewidth=0.7)
    _scale(axes, panel)
    if panel.is_log:  # an interval may reach below zero
        known = [row[panel.column] for row in rows if row[panel.column]]
        axes.set_ylim(bottom=min(known) / 2, top=2 * axes.get_ylim()[1])


def _draw_point(
    axes: Axes,
    at: float,
    values: Sequence[float | None],
    method: str,
    light: str,
    panel: _Panel,
) -> None:
    style, known = method_style(method), [value for value in values if value is not None]
    found = mean_interval(known, is_share=panel.is_share)
    if found is None:
        if values:  # of a method that has it elsewhere
            axes.plot([at], [0.94], transform=axes.get_xaxis_transform(), **_cross(style.colour))
        return
    scale = 100.0 if panel.is_share else 1.0
    line = light_line(light, style.colour) | {"linestyle": "none", "markersize": 5.5}
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
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    else:
        axes.set_ylim(bottom=-0.07 * axes.get_ylim()[1])
    if panel.column == _LOAD:
        axes.axhline(1.0, color="black", linestyle=":", linewidth=1.0)


def _notes(rows: Sequence[Row], panels: Sequence[_Panel]) -> list[Line2D]:
    dotted = Line2D([], [], color="black", linestyle=":", linewidth=1.0, label="real time")
    found = {
        (panel.column, row["sequence"], row["method"])
        for panel in panels
        for row in rows
        if row[panel.column] is not None
    }
    able = {(column, method) for column, _, method in found}
    tried = {
        (column, row["sequence"], method)
        for row in rows
        for column, method in able
        if row["method"] == method
    }
    never = Line2D([], [], label="never", **_cross("#4a5058"))
    return [dotted, never] if tried - found else [dotted]


def _cross(colour: str) -> dict[str, Any]:
    return {"color": colour, "marker": "x", "markersize": 6, "linestyle": "none", "mew": 1.6}
