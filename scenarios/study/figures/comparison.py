"""Comparison of the methods: velocity, GRMS, direction and CPU time (paper, Fig. EX3)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import fmean

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from matplotlib.ticker import LogLocator, NullFormatter

from detector.metrics import within
from flybench.direction import Direction
from scenarios.output.figures import figure_file
from scenarios.pipeline.registry import gives_velocity, is_fly
from scenarios.pipeline.scoring import SETTLING_US
from scenarios.study.figures.sequence_axis import (
    TRUTH_LINE,
    add_legend,
    label_methods,
    label_sequences,
    methods_of,
    truth_handle,
)
from scenarios.study.results import MethodRun, SequenceResult
from scenarios.styles.lighting_style import lighting_style
from scenarios.styles.method_style import method_style

Sequences = Sequence[SequenceResult]
Value = Callable[[SequenceResult, MethodRun], float | None]

WIDTH_IN, _TOP_IN, _METHOD_IN = 7.8, 3.0, 0.42
"""Width of the figure, and heights of the upper panels and of a method in the lower ones [inch]."""
_STRONG = 0.6
"""Opacity of a cell's colour above which its text has the colour of the paper (by eye)."""


def draw_comparison(path: Path, sequences: Sequences) -> None:
    """Draw panels A to D like the paper's; day is filled and solid, night hollow and dashed.

    Args:
        path: path of the figure, without a suffix.
        sequences: one result or more, by day, at night or both.
    """
    low_in = 0.5 + _METHOD_IN * max(len(methods_of(sequences)), 5)
    with figure_file(path, (WIDTH_IN, 1.0 + _TOP_IN + low_in)) as figure:
        grid = figure.subplots(2, 2, height_ratios=(_TOP_IN, low_in))
        (top_left, top_right), (low_left, low_right) = grid
        _draw_velocities(top_left, sequences)
        _draw_grms(top_right, sequences)
        _draw_directions(low_left, sequences)
        _draw_times(low_right, sequences)
        add_legend(figure, sequences, [truth_handle()])


def _draw_velocities(axes: Axes, sequences: Sequences) -> None:
    axes.set_title("A\u2002image velocity")
    omegas = sorted({one.omega_rad_s for one in sequences})
    truth = [
        fmean(one.image_speed_px_s for one in sequences if one.omega_rad_s == omega)
        for omega in omegas
    ]
    axes.plot(omegas, truth, marker="_", markersize=9, **TRUTH_LINE)
    for method in methods_of(sequences):
        if gives_velocity(method):
            _draw_by_omega(axes, sequences, method, _mean_speed_px_s)
    axes.set(xlabel="angular velocity [rad/s]", ylabel="image speed [px/s]")
    axes.set_ylim(bottom=0)


def _draw_grms(axes: Axes, sequences: Sequences) -> None:
    axes.set_title("B\u2002GRMS of the response")
    for method in methods_of(sequences):
        if is_fly(method):
            _draw_by_omega(axes, sequences, method, lambda _, run: run.scores["grms"])
    axes.set_ylim(bottom=0)
    power = math.floor(math.log10(axes.get_ylim()[1]))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value / 10**power:g}")
    unit = "1/s" if power == 0 else f"$10^{{{power}}}$/s"
    axes.set(xlabel="angular velocity [rad/s]", ylabel=f"GRMS [{unit}]")


def _draw_by_omega(axes: Axes, sequences: Sequences, method: str, value: Value) -> None:
    """Draw a faint line for each seed and a bold line for their mean, for each lighting."""
    style = method_style(method)
    for lighting in dict.fromkeys(one.lighting for one in sequences):
        by_omega = {
            one.omega_rad_s: _by_seed(one, method, value)
            for one in sequences
            if one.lighting == lighting
        }
        found = {omega: seeds for omega, seeds in sorted(by_omega.items()) if seeds}
        line = lighting_style(lighting, style.colour)
        for seed in sorted({seed for seeds in found.values() for seed in seeds}):
            own = [(omega, seeds[seed]) for omega, seeds in found.items() if seed in seeds]
            axes.plot(*np.transpose(own), color=style.colour, alpha=0.3, linewidth=0.7)
        means = [fmean(seeds.values()) for seeds in found.values()]
        axes.plot(list(found), means, marker=style.marker, **line)


def _by_seed(sequence: SequenceResult, method: str, value: Value) -> dict[int, float]:
    runs = [run for run in sequence.runs if run.method == method]
    found = {run.seed: value(sequence, run) for run in runs}
    return {seed: number for seed, number in found.items() if number is not None}


def _mean_speed_px_s(sequence: SequenceResult, run: MethodRun) -> float | None:
    """Return the mean of the settled steps that name a direction, along the true direction."""
    settled = sequence.in_view_us[0] + SETTLING_US, sequence.in_view_us[1]
    named = [e for e in within(run.estimates, settled) if e.direction is not Direction.NONE]
    sign = 1.0 if sequence.direction in (Direction.RIGHT, Direction.DOWN) else -1.0
    return sign * fmean(e.response[0] for e in named) if named else None


def _draw_directions(axes: Axes, sequences: Sequences) -> None:
    """Draw a cell for each method and sequence: the number of seeds with a correct verdict."""
    axes.set_title("C\u2002seeds with the correct direction")
    methods = methods_of(sequences)
    for row, method in enumerate(methods):
        for column, sequence in enumerate(sequences):
            _draw_cell(axes, column, row, sequence, method)
    label_sequences(axes, sequences)
    axes.set(ylim=(len(methods) - 0.5, -0.5))
    label_methods(axes, methods)
    axes.spines[:].set_visible(False)


def _draw_cell(axes: Axes, column: int, row: int, sequence: SequenceResult, method: str) -> None:
    runs = [run for run in sequence.runs if run.method == method]
    if not runs:
        return
    correct = sum(run.scores["direction"] == sequence.direction for run in runs)
    share, corner = correct / len(runs), (column - 0.46, row - 0.4)
    shade = (method_style(method).colour, share)  # transparent, for light and dark pages
    axes.add_patch(Rectangle(corner, 0.92, 0.8, facecolor=shade, edgecolor="#c9d0d8"))
    ink = "white" if share > _STRONG else "black"
    text = f"{correct}/{len(runs)}"
    axes.text(column, row, text, ha="center", va="center", fontsize=8, color=ink)


def _draw_times(axes: Axes, sequences: Sequences) -> None:
    """Draw the CPU time of an estimate: a tick for each sequence and seed, and their mean."""
    axes.set_title("D\u2002CPU time")
    methods = methods_of(sequences)
    lightings = list(dict.fromkeys(one.lighting for one in sequences))
    for row, method in enumerate(methods):
        for number, lighting in enumerate(lightings):
            height = row + 0.32 * (number - (len(lightings) - 1) / 2)
            own = [one for one in sequences if one.lighting == lighting]
            _draw_time(axes, height, method, lighting, [t for s in own for t in _ms(s, method)])
    axes.set(ylim=(len(methods) - 0.5, -0.5), xscale="log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("CPU time of an estimate [ms]")
    axes.grid(axis="x", color="#e3e6ea", linewidth=0.6)
    axes.set_axisbelow(True)
    label_methods(axes, methods)


def _draw_time(
    axes: Axes, height: float, method: str, lighting: str, times_ms: list[float]
) -> None:
    if not times_ms:
        return
    style = method_style(method)
    axes.plot(
        times_ms, [height] * len(times_ms), ls="none", marker="|", color=style.colour, alpha=0.4
    )
    line = lighting_style(lighting, style.colour) | {"linestyle": "none", "marker": style.marker}
    mean_ms = fmean(times_ms)
    axes.plot([mean_ms], [height], **line)
    axes.annotate(
        f"{mean_ms:.3g}, {lighting}",
        (max(times_ms), height),
        xytext=(8, 0),
        textcoords="offset points",
        va="center",
        fontsize=7,
        annotation_clip=False,
    )


def _ms(sequence: SequenceResult, method: str) -> list[float]:
    """Return the CPU time of an estimate, for each seed [ms]."""
    runs = [run for run in sequence.runs if run.method == method]
    return [1e3 * run.cpu_s / len(run.estimates) for run in runs if run.estimates]
