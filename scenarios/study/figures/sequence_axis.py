"""Axes with a position for each sequence or method."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from itertools import groupby
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from scenarios.study.results import SequenceResult
from scenarios.styles.lighting_style import lighting_style
from scenarios.styles.method_style import in_display_order, method_style

TRUTH_LINE: Any = {"color": "black", "linestyle": "--", "linewidth": 1.1}
_LINE_LETTERS = 14
"""Letters in one line of a label beside a panel."""


def label_sequences(axes: Axes, sequences: Sequence[SequenceResult]) -> None:
    """Label the x positions 0, 1, 2, ... with velocities, and below them with the lighting."""
    axes.set_xlim(-0.5, len(sequences) - 0.5)
    axes.set_xticks(range(len(sequences)), [f"{one.omega_rad_s:.2f}" for one in sequences])
    middles, labels, first = [], [], 0
    for lighting, group in groupby(one.lighting for one in sequences):
        number = len(list(group))
        middles.append(first + (number - 1) / 2)
        labels.append(f"{lighting} [rad/s]")
        first += number
    axes.set_xticks(middles, labels, minor=True)
    axes.xaxis.remove_overlapping_locs = False  # a lighting may be at the position of a velocity
    axes.tick_params(axis="x", length=0, labelsize=8)
    axes.tick_params(axis="x", which="minor", length=0, pad=16, labelsize=9)


def label_methods(axes: Axes, methods: Sequence[str]) -> None:
    """Label the y positions 0, 1, 2, ... with the methods."""
    names = [wrap_label(method_style(method).label) for method in methods]
    axes.set_yticks(range(len(methods)), names)
    axes.tick_params(axis="y", length=0, labelsize=8)


def wrap_label(label: str) -> str:
    """Break a label into lines that fit beside a panel."""
    return textwrap.fill(label, _LINE_LETTERS)


def truth_handle() -> Line2D:
    """Return the legend entry for true values."""
    return Line2D([], [], label="truth", **TRUTH_LINE)


def methods_of(sequences: Sequence[SequenceResult]) -> list[str]:
    """Return the methods that ran, each once, in the order of all figures."""
    return in_display_order(run.method for one in sequences for run in one.runs)


def add_legend(
    figure: Figure, sequences: Sequence[SequenceResult], more: Sequence[Line2D] = ()
) -> None:
    """Add a legend below all panels, with the methods, day and night, and more entries."""
    handles = []
    for method in methods_of(sequences):
        style = method_style(method)
        line = lighting_style("day", style.colour)
        handles.append(Line2D([], [], marker=style.marker, label=style.label, **line))
    for lighting in dict.fromkeys(one.lighting for one in sequences):
        line = lighting_style(lighting, "#4a5058")
        handles.append(Line2D([], [], marker="o", label=lighting, **line))
    figure.legend(handles=[*handles, *more], loc="outside lower center", ncols=4, fontsize=8)
