"""The picture at the top of the report: correct steps of every method, by day and at night."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from scenarios.output.figures import figure_file
from scenarios.study.figures.sequence_axis import methods_of
from scenarios.study.results import SequenceResult
from scenarios.study.rows import Row, study_rows
from scenarios.study.statistics import distinct, interval_of, select
from scenarios.styles.lighting_style import lighting_style
from scenarios.styles.method_style import method_style

WIDTH_IN, _METHOD_IN = 4.5, 0.34
_APART = 0.17
"""Distance of day and night from the middle of a method's row."""


def draw_overview(path: Path, sequences: Sequence[SequenceResult]) -> None:
    """Draw one row for each method: mean over the seeds and 95 % interval, by lighting.

    Args:
        path: path of the figure, without a suffix.
        sequences: one result or more, by day, at night or both.
    """
    methods, rows = methods_of(sequences), study_rows(sequences)
    lightings = distinct(rows, "lighting")
    with figure_file(path, (WIDTH_IN, 1.0 + _METHOD_IN * len(methods))) as figure:
        axes = figure.add_subplot()
        for place, method in enumerate(methods):
            for number, lighting in enumerate(lightings):
                height = place + _APART * (2 * number - len(lightings) + 1)
                _draw_point(axes, height, method, select(rows, method=method, lighting=lighting))
        axes.set(xlim=(-3, 103), ylim=(len(methods) - 0.5, -0.5))
        axes.set_yticks(range(len(methods)), [method_style(method).label for method in methods])
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel("correct steps after 100 ms in view [%]")
        axes.grid(axis="x", color="#e3e6ea", linewidth=0.6)
        axes.set_axisbelow(True)
        handles = [
            Line2D([], [], marker="o", label=name, **lighting_style(name, "#4a5058") | {"ls": ""})
            for name in lightings
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))


def _draw_point(axes: Axes, height: float, method: str, rows: Sequence[Row]) -> None:
    found = interval_of(rows, "accuracy_after_100ms")
    if found is None:
        return
    style = method_style(method)
    look = lighting_style(rows[0]["lighting"], style.colour) | {"linestyle": "none"}
    axes.plot([100 * found.low, 100 * found.high], [height] * 2, color=style.colour, linewidth=1.4)
    axes.plot([100 * found.mean], [height], marker=style.marker, **look)
