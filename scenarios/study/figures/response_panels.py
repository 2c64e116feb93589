"""Panels of a method's response or velocity over the time of one crossing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from detector.estimate import MotionEstimate
from flybench.direction import Direction
from scenarios.study.figures.curves import F64, Curve, Value, curve, mean_curve
from scenarios.study.results import MethodRun, SequenceResult
from scenarios.styles.method_style import MethodStyle, method_style

BESIDE_US = 120_000
"""Time shown before and after the vehicle is in view [µs]."""
VERTICAL = "#80868e"
NO_DECISION, WRONG = "#d5d8dc", "#000000"
_IN_VIEW = "#f1f3f5"
_STRIP_AT, _LOWEST, _HIGHEST = -1.25, -1.42, 1.08
_FEW = 45
"""Number of steps up to which each step is marked by a dot, to show how rare they are (assumed)."""
_HEADROOM = 1.5
"""Top of a velocity panel, in units of the highest true velocity (assumed)."""


def draw_response(axes: Axes, sequence: SequenceResult, method: str) -> None:
    """Draw HS and VS over time, with a faint line for each seed and a bold line for their mean.

    A strip below shows whether each decision of the first seed was correct.
    """
    runs, colour = runs_of(sequence, method), method_style(method).colour
    _time_axis(axes, sequence)
    _draw_curves(axes, sequence, runs, lambda e: e.vs, VERTICAL)
    _draw_curves(axes, sequence, runs, lambda e: e.hs, colour)
    if runs:
        _draw_decisions(axes, sequence, runs[0], colour)
        _label_peak(axes, mean_curve([curve(run, lambda e: e.hs) for run in runs]))
    axes.set(ylim=(_LOWEST, _HIGHEST), yticks=(-1, 0, 1))


def draw_velocity(axes: Axes, sequence: SequenceResult, method: str, *, top_px_s: float) -> None:
    """Draw the estimated and the true horizontal image velocity over time.

    Steps that name no direction leave a gap. Velocities outside the panel are small arrows at its
    edge.

    Args:
        axes: axes to draw on.
        sequence: result of the sequence.
        method: a method whose response is a velocity.
        top_px_s: highest true velocity of all panels [px/s].
    """
    runs = runs_of(sequence, method)
    _time_axis(axes, sequence)
    _draw_curves(axes, sequence, runs, _named_velocity_px_s, method_style(method).colour)
    _draw_truth(axes, sequence)
    low, high = -0.3 * top_px_s, _HEADROOM * top_px_s
    if sequence.direction in (Direction.LEFT, Direction.UP):
        low, high = -high, -low
    axes.set_ylim(low, high)
    for run in runs:
        _draw_out_of_range(
            axes, sequence, curve(run, _named_velocity_px_s), method_style(method).colour
        )


def runs_of(sequence: SequenceResult, method: str) -> list[MethodRun]:
    """Return the runs of a method with any estimates, in order of the seeds."""
    runs = [run for run in sequence.runs if run.method == method and run.estimates]
    return sorted(runs, key=lambda run: run.seed)


def response_handles(style: MethodStyle) -> list[Line2D]:
    """Return legend entries for the lines and the strip of a response panel."""
    return [
        _line(style.colour, "HS"),
        _line(VERTICAL, "VS"),
        _square(style.colour, "correct decision"),
        _square(WRONG, "wrong decision"),
        _square(NO_DECISION, "no decision"),
    ]


def velocity_handles(style: MethodStyle) -> list[Line2D]:
    """Return legend entries for the lines of a velocity panel."""
    truth = Line2D([], [], color="black", linestyle="--", linewidth=1.1, label="true velocity")
    return [_line(style.colour, "estimated velocity"), truth]


def _line(colour: str, label: str) -> Line2D:
    return Line2D([], [], color=colour, linewidth=1.6, label=label)


def _square(colour: str, label: str) -> Line2D:
    return Line2D([], [], color=colour, ls="none", marker="s", markersize=6, label=label)


def _named_velocity_px_s(estimate: MotionEstimate) -> float:
    return math.nan if estimate.direction is Direction.NONE else estimate.response[0]


def _time_axis(axes: Axes, sequence: SequenceResult) -> None:
    enters_us, leaves_us = sequence.in_view_us
    first = max(-enters_us, -BESIDE_US)
    last = min(sequence.duration_us, leaves_us + BESIDE_US) - enters_us
    axes.axvspan(0, (leaves_us - enters_us) / 1e6, color=_IN_VIEW, linewidth=0, zorder=0)
    axes.axhline(0, color="#b7bcc2", linewidth=0.6, zorder=1)
    axes.set_xlim(first / 1e6, max(last, first + 1) / 1e6)


def _draw_curves(
    axes: Axes,
    sequence: SequenceResult,
    runs: Sequence[MethodRun],
    value: Value,
    colour: str,
) -> None:
    curves = [curve(run, value) for run in runs]
    if len(curves) > 1:
        for one in curves:
            _plot(axes, sequence, one, color=colour, alpha=0.3, linewidth=0.6)
    _plot(axes, sequence, mean_curve(curves), color=colour, linewidth=1.6)


def _plot(
    axes: Axes,
    sequence: SequenceResult,
    one: Curve,
    *,
    color: str,
    linewidth: float,
    alpha: float = 1.0,
) -> None:
    axes.plot(
        _time_in_view_s(one.t_us, sequence),
        one.values,
        color=color,
        linewidth=linewidth,
        alpha=alpha,
        marker="." if one.t_us.size <= _FEW and alpha == 1.0 else "",
        markersize=4,
    )


def _draw_truth(axes: Axes, sequence: SequenceResult) -> None:
    enters_us, leaves_us = sequence.in_view_us
    times, values = sequence.velocity_t_us, sequence.velocity_px_s
    in_view = (times >= enters_us) & (times <= leaves_us)
    times_s = _time_in_view_s(times[in_view], sequence)
    axes.plot(times_s, values[in_view], color="black", ls="--", lw=1.1)


def _draw_out_of_range(axes: Axes, sequence: SequenceResult, one: Curve, colour: str) -> None:
    low, high = axes.get_ylim()
    for outside, edge, marker in ((one.values > high, high, "^"), (one.values < low, low, "v")):
        if outside.any():
            times_s = _time_in_view_s(one.t_us[outside], sequence)
            at = np.full(times_s.shape, edge)
            axes.plot(times_s, at, color=colour, ls="none", marker=marker, ms=3, alpha=0.6)


def _draw_decisions(axes: Axes, sequence: SequenceResult, run: MethodRun, colour: str) -> None:
    truth = Direction(sequence.direction)
    colours = {truth: colour, Direction.NONE: NO_DECISION}
    times_s = _time_in_view_s(np.array([e.t_us for e in run.estimates], np.float64), sequence)
    ends_s = np.append(times_s[1:], times_s[-1])
    step_colours = [colours.get(e.direction, WRONG) for e in run.estimates]
    first = 0
    for step_colour, group in groupby(step_colours):  # one bar, to avoid seams between equal steps
        last = first + len(list(group)) - 1
        span = (float(times_s[first]), float(ends_s[last] - times_s[first]))
        axes.broken_barh([span], (_STRIP_AT - 0.1, 0.2), facecolor=step_colour, linewidth=0)
        first = last + 1


def _label_peak(axes: Axes, mean: Curve) -> None:
    """Print the peak of HS, which may not be visible on the common scale of all methods."""
    if mean.values.size:
        peak = float(mean.values[np.abs(mean.values).argmax()])
        text = f"peak HS {peak:.2g}".replace("-", "−")
        at = 0.3 if peak >= 0 else 0.98  # away from HS
        axes.text(0.98, at, text, transform=axes.transAxes, fontsize=7, ha="right", va="top")


def _time_in_view_s(times_us: npt.NDArray[Any], sequence: SequenceResult) -> F64:
    return (times_us.astype(np.float64) - sequence.in_view_us[0]) / 1e6
