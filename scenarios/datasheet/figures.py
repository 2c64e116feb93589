"""Plots of the data sheet as SVG, for use inside a page."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emulator.characterisation import Plot, Series, Style

SIZE_IN = (4.4, 3.3)
"""Width and height of a plot: small enough for its text to be readable on a phone [inch]."""
_LEGEND_LETTERS = 54
"""Letters that fit in one line of a legend."""
_FEW_COLOURS = ("#0b5fa5", "#d1495b", "#2f8f5b", "#7a5195", "#6b6b6b")
_RC: Any = {
    "svg.fonttype": "none",
    "svg.hashsalt": "flybench",
    "font.family": "sans-serif",
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e6ea",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.6,
    "lines.markersize": 3.5,
}


def draw_svg(plot: Plot) -> str:
    """Draw a plot as an `<svg>` element; the same plot gives the same text."""
    with mpl.rc_context(_RC):
        file = io.StringIO()
        figure = draw(plot)
        figure.savefig(file, format="svg", metadata={"Date": None, "Creator": None})
    text = file.getvalue()
    return text[text.index("<svg") :]


def draw(plot: Plot) -> Figure:
    """Draw a plot as a matplotlib figure."""
    figure = Figure(figsize=SIZE_IN, layout="constrained")
    axes = figure.add_subplot()
    indices = _colour_indices(plot.series)
    colours = _colours(max(indices, default=0) + 1)
    for series, index in zip(plot.series, indices, strict=True):
        _draw_series(axes, series, colours[index % len(colours)])
    axes.set_title(plot.title, loc="left", fontweight="bold")
    axes.set_xlabel(plot.x_label)
    axes.set_ylabel(plot.y_label)
    if plot.x_log:
        axes.set_xscale("log")
    if plot.y_log:
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=min(0.0, _lowest(plot.series)))
    axes.set_axisbelow(True)
    _add_legend(axes)
    return figure


def _draw_series(axes: Axes, series: Series, colour: str) -> None:
    label = series.label or None
    if series.style is Style.PUBLISHED:
        axes.plot(
            series.x,
            series.y,
            linestyle="none",
            marker="D",
            markersize=6,
            markerfacecolor="white",
            markeredgecolor=colour if series.colour_index is not None else "black",
            markeredgewidth=1.4,
            label=label,
            zorder=5,
        )
    elif series.style is Style.POINTS:
        axes.plot(series.x, series.y, linestyle="none", marker="o", color=colour, label=label)
    elif series.style is Style.GUIDE:
        axes.plot(series.x, series.y, color="#6b6b6b", linestyle="--", linewidth=1.0, label=label)
    elif series.style is Style.STEPS:
        axes.plot(series.x, series.y, drawstyle="steps-mid", color=colour, label=label)
    else:
        few = series.x.size <= 16
        axes.plot(series.x, series.y, marker="o" if few else "", color=colour, label=label)


def _colour_indices(series: Sequence[Series]) -> list[int]:
    return [n if one.colour_index is None else one.colour_index for n, one in enumerate(series)]


def _colours(number: int) -> Sequence[str]:
    """Return distinct colours for a few curves, and a sequential colour scale for many."""
    if number <= len(_FEW_COLOURS):
        return _FEW_COLOURS
    scale = mpl.colormaps["viridis"]
    return [mpl.colors.to_hex(scale(0.93 * k / (number - 1))) for k in range(number)]


def _lowest(series: Sequence[Series]) -> float:
    values = np.concatenate([one.y[np.isfinite(one.y)] for one in series] or [np.zeros(1)])
    return float(values.min()) if values.size else 0.0


def _add_legend(axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    if len(labels) > 1:
        columns = max(1, min(4, len(labels), _LEGEND_LETTERS // max(map(len, labels))))
        axes.figure.legend(handles, labels, loc="outside lower center", ncols=columns)
