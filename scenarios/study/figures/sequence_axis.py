"""Axes with a place for each sequence, and for each method; what day and night look like."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from itertools import groupby
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from scenarios.study import results
from scenarios.study.figures.method_style import in_order, method_style

TRUTH_LINE: Any = {"color": "black", "linestyle": "--", "linewidth": 1.1}
_LETTERS = 14
"""Of a name, on one line beside a panel."""


def name_sequences(axes: Axes, sequences: Sequence[results.Sequence]) -> None:
    """Name the places 0, 1, 2 and so on across: velocities, and below them the light of each."""
    axes.set_xlim(-0.5, len(sequences) - 0.5)
    axes.set_xticks(range(len(sequences)), [f"{one.omega_rad_s:.2f}" for one in sequences])
    middles, lights, first = [], [], 0
    for light, group in groupby(one.lighting for one in sequences):
        number = len(list(group))
        middles.append(first + (number - 1) / 2)
        lights.append(f"{light} [rad/s]")
        first += number
    axes.set_xticks(middles, lights, minor=True)
    axes.xaxis.remove_overlapping_locs = False  # a light's name may stand below a velocity's
    axes.tick_params(axis="x", length=0, labelsize=8)
    axes.tick_params(axis="x", which="minor", length=0, pad=16, labelsize=9)


def name_methods(axes: Axes, methods: Sequence[str]) -> None:
    """Name the places 0, 1, 2 and so on up or down: the methods."""
    names = [wrapped(method_style(method).label) for method in methods]
    axes.set_yticks(range(len(methods)), names)
    axes.tick_params(axis="y", length=0, labelsize=8)


def wrapped(label: str) -> str:
    """A method's name on lines short enough to stand beside a panel."""
    return textwrap.fill(label, _LETTERS)


def light_line(light: str, colour: str) -> dict[str, Any]:
    """How a light is drawn: by day filled and solid, else hollow and dashed."""
    is_day = light == "day"
    return {
        "color": colour,
        "linestyle": "-" if is_day else (0, (4, 2)),
        "linewidth": 1.7,
        "markersize": 6,
        "markerfacecolor": colour if is_day else "white",
        "markeredgecolor": colour,
        "markeredgewidth": 1.4,
    }


def truth_handle() -> Line2D:
    """What a line of the truth means."""
    return Line2D([], [], label="truth", **TRUTH_LINE)


def methods_of(sequences: Sequence[results.Sequence]) -> list[str]:
    """The methods that ran, each once, in the order of every figure."""
    return in_order(run.method for one in sequences for run in one.runs)


def add_legend(
    figure: Figure, sequences: Sequence[results.Sequence], more: Sequence[Line2D] = ()
) -> None:
    """One legend below all panels: each method's colour, and what day and night look like."""
    handles = []
    for method in methods_of(sequences):
        style = method_style(method)
        line = light_line("day", style.colour)
        handles.append(Line2D([], [], marker=style.marker, label=style.label, **line))
    for light in dict.fromkeys(one.lighting for one in sequences):
        line = light_line(light, "#4a5058")
        handles.append(Line2D([], [], marker="o", label=light, **line))
    figure.legend(handles=[*handles, *more], loc="outside lower center", ncols=4, fontsize=8)
