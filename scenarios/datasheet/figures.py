"""Plots of the data sheet as SVG, for use inside a page."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from emulator.characterisation import Plot, Series, Style
from scenarios.output.colours import OFF, ON, SERIES, Rgb, hex_of

SIZE_IN = (4.4, 3.3)
"""Width and height of a plot: small enough for its text to be readable on a phone [inch]."""
_LEGEND_LETTERS, _KEY_LETTERS = 66, 6
"""Letters that fit in one line of a legend, and the width of the sign before each name."""
_MARKERS, _LINES = "osD^v", ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))
"""Markers and lines of a few curves, in turn, since colour alone does not distinguish them for all.
"""
_LOW, _HIGH = 0.28, 0.75
"""Part of Matplotlib's viridis that is visible on white and on a dark page (by eye)."""
_FEW_POINTS = 16
"""Most points of a curve that are marked one by one."""
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
    draw_on(axes, plot)
    _add_legend(axes)
    return figure


def draw_on(axes: Axes, plot: Plot) -> None:
    """Draw a plot on axes, with its labels but no legend."""
    looks = _looks(plot.series)
    for series in plot.series:
        _draw_series(axes, series, looks[id(series)])
    axes.set_title(plot.title, loc="left", fontweight="bold")
    axes.set_xlabel(plot.x_label)
    axes.set_ylabel(plot.y_label)
    if plot.x_log:
        axes.set_xscale("log")
        low, high = axes.get_xlim()
        if high > 10.0 * low:  # labels of less than a decade would overlap
            axes.xaxis.set_minor_formatter(NullFormatter())
    if plot.y_log:
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=min(0.0, _lowest(plot.series)))
    axes.set_axisbelow(True)


@dataclass(frozen=True)
class _Look:
    """Colour, marker and line of one curve."""

    colour: str
    marker: str
    line: Any


def _draw_series(axes: Axes, series: Series, look: _Look) -> None:
    draw, label = axes.plot, series.label or None
    if series.style is Style.PUBLISHED:
        draw(
            series.x,
            series.y,
            linestyle="none",
            marker="D",
            markersize=6,
            markerfacecolor="white",
            markeredgecolor=look.colour if series.colour_index is not None else "black",
            markeredgewidth=1.4,
            label=label,
            zorder=5,
        )
    elif series.style is Style.POINTS:
        draw(series.x, series.y, ls="none", marker=look.marker, color=look.colour, label=label)
    elif series.style is Style.GUIDE:
        draw(series.x, series.y, color="#6b6b6b", linestyle="--", linewidth=1.0, label=label)
    elif series.style is Style.STEPS:
        draw(series.x, series.y, drawstyle="steps-mid", color=look.colour, label=label)
    else:
        marker = look.marker if series.x.size <= _FEW_POINTS else ""
        draw(series.x, series.y, ls=look.line, marker=marker, color=look.colour, label=label)


def _looks(series: Sequence[Series]) -> dict[int, _Look]:
    """Return the look of each series, by its id; series with the same index share one."""
    indices = [n if one.colour_index is None else one.colour_index for n, one in enumerate(series)]
    number = max(indices, default=0) + 1
    colours = _colours(number) | {
        index: hex_of(rgb)
        for one, index in zip(series, indices, strict=True)
        if (rgb := _polarity_colour(one.label)) is not None
    }
    distinct = number <= len(SERIES)
    return {
        id(one): _Look(
            colours[index],
            _MARKERS[index % len(_MARKERS)],
            _LINES[index] if distinct else "-",
        )
        for one, index in zip(series, indices, strict=True)
    }


def _colours(number: int) -> dict[int, str]:
    """Return distinct colours for a few curves, and a sequential colour scale for many."""
    if number <= len(SERIES):
        return dict(enumerate(SERIES))
    scale = mpl.colormaps["viridis"]
    return {
        k: mpl.colors.to_hex(scale(_LOW + (_HIGH - _LOW) * k / (number - 1))) for k in range(number)
    }


def _polarity_colour(label: str) -> Rgb | None:
    """Return the colour of the one polarity that a label names; None if it names none or both."""
    named = [rgb for word, rgb in (("ON", ON), ("OFF", OFF)) if re.search(rf"\b{word}\b", label)]
    return named[0] if len(named) == 1 else None


def _lowest(series: Sequence[Series]) -> float:
    values = np.concatenate([one.y[np.isfinite(one.y)] for one in series] or [np.zeros(1)])
    return float(values.min()) if values.size else 0.0


def _add_legend(axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    if len(labels) > 1:
        width = _KEY_LETTERS + max(map(len, labels))
        columns = max(1, min(4, len(labels), _LEGEND_LETTERS // width))
        axes.figure.legend(handles, labels, loc="outside lower center", ncols=columns)
