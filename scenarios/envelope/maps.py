"""The envelope as maps: speed across, another factor up, the share of correct steps as colour."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from scenarios.envelope.grid import BASE, NOISE, SPEED
from scenarios.envelope.table import (
    F64,
    HOLDS,
    NONE,
    OPPOSITE,
    RIGHT,
    Row,
    at_base,
    levels,
    means,
    worst,
)
from scenarios.output.figures import figure_file

_VALUES = {
    RIGHT: "share of steps with the correct direction, %",
    OPPOSITE: "share of steps with the opposite direction, %",
    NONE: "share of steps that name no direction, %",
}
_COLOURS = {
    RIGHT: mpl.colormaps["YlGnBu"],
    OPPOSITE: LinearSegmentedColormap.from_list("wrong", ["white", "#f4a582", "#b2182b"]),
    NONE: LinearSegmentedColormap.from_list("silent", ["white", "#222222"]),
}
_DARK = 0.6
"""Of the colour scale; beyond, letters are white."""
_LETTERS_AN_INCH = 17
"""Of the footnote, in 7 points."""
_LINE: Any = {
    "color": "#e4572e",
    "linewidth": 1.8,
    "clip_on": False,
    "solid_capstyle": "projecting",
}
PAPER_PX_S = (347.0, 784.0)
"""Slowest and fastest of the paper's eight sequences: 1.07 to 2.42 rad/s at 324 px a radian."""
_NAMES = {
    SPEED: "image speed [px/s]",
    NOISE: "noise [Hz a pixel]",
    "contrast": "contrast [SD of ln L]",
    "direction": "direction",
    "length_px": "target's length [px]",
    "surface": "target's surface",
    "background": "what else moves",
}


def draw_method(path: Path, rows: Sequence[Row], value: str, *, crossed: Sequence[str]) -> None:
    """A slide: one result of one method, by speed and noise, and by speed and every other factor.

    Args:
        path: of the figure, without a suffix.
        rows: of one method.
        value: the result, a share of the steps: `RIGHT`, `OPPOSITE` or `NONE`.
        crossed: factors over whose levels the map of speed and noise is averaged.
    """
    factors = [name for name in _NAMES if name not in (SPEED, NOISE) and _varies(rows, name)]
    columns = min(3, 1 + len(factors))
    lines = -(-(1 + len(factors)) // columns)
    with figure_file(path, (0.4 + 4.3 * columns, 1.0 + 2.9 * lines)) as figure:
        figure.suptitle(f"{rows[0]['method']}: {_VALUES[value]}", x=0.01, ha="left")
        first, *others = figure.subplots(lines, columns, squeeze=False).ravel()
        full = at_base(rows, (SPEED, NOISE, *crossed))
        draw_map(first, full, NOISE, value, title=f"by noise{_mean_of(crossed)}")
        for axes, factor in zip(others, factors, strict=False):
            own = at_base(rows, (SPEED, factor))
            draw_map(axes, own, factor, value, title=f"by {_short(factor)}")
        for axes in others[len(factors) :]:
            axes.remove()
        _footnote(figure, rows)


def draw_comparison(path: Path, rows: Sequence[Row], *, crossed: Sequence[str]) -> None:
    """All methods side by side: correct steps by speed and noise, and the worst crossed level."""
    methods = levels(rows, "method")
    with figure_file(path, (4.4 * len(methods) + 0.4, 3.2 + 3.0 * len(crossed))) as figure:
        grid = figure.subplots(1 + len(crossed), len(methods), squeeze=False)
        for column, method in enumerate(methods):
            own = [row for row in rows if row["method"] == method]
            own = at_base(own, (SPEED, NOISE, *crossed))
            title = f"{method}: correct, %{_mean_of(crossed)}"
            draw_map(grid[0, column], own, NOISE, RIGHT, title=title)
            for axes, factor in zip(grid[1:, column], crossed, strict=True):
                lowest = worst(own, SPEED, NOISE, factor, RIGHT)
                _draw_cells(axes, own, NOISE, RIGHT, lowest)
                axes.set_title(f"{method}: worst {_short(factor)}", pad=9)
        _footnote(figure, rows)


def draw_levels(path: Path, rows: Sequence[Row], factor: str) -> None:
    """Speed by noise for every level of a crossed factor: a row a method, a column a level."""
    methods, measured = levels(rows, "method"), levels(rows, factor)
    size = 3.3 * len(measured) + 0.4, 2.9 * len(methods) + 0.5
    with figure_file(path, size) as figure:
        grid = figure.subplots(len(methods), len(measured), squeeze=False)
        for line, method in zip(grid, methods, strict=True):
            for axes, level in zip(line, measured, strict=True):
                own = [r for r in rows if r["method"] == method and r[factor] == level]
                own = at_base(own, (SPEED, NOISE, factor))
                title = f"{method}: correct, {_short(factor)} {level}"
                draw_map(axes, own, NOISE, RIGHT, title=title)
        _footnote(figure, rows)


def draw_map(axes: Axes, rows: Sequence[Row], factor: str, value: str, *, title: str) -> None:
    """One map: a result by speed and another factor, each cell the mean over all else."""
    _draw_cells(axes, rows, factor, value, means(rows, SPEED, factor, value))
    axes.set_title(title, pad=9)


def _draw_cells(axes: Axes, rows: Sequence[Row], factor: str, value: str, cells: F64) -> None:
    speeds, others = levels(rows, SPEED), levels(rows, factor)
    axes.imshow(cells, cmap=_COLOURS[value], vmin=0, vmax=1, aspect="auto", origin="lower")
    axes.spines[:].set_visible(False)
    axes.set_xticks(range(len(speeds)), [f"{v:g}" for v in speeds], rotation=60, fontsize=7)
    axes.set_yticks(range(len(others)), [_label(level) for level in others], fontsize=8)
    axes.set_xlabel(_NAMES[SPEED], fontsize=8)
    axes.set_ylabel(_NAMES[factor], fontsize=8)
    axes.tick_params(length=0)
    plain = 1 if value == RIGHT else 0
    for (y, x), share in np.ndenumerate(cells):
        if not np.isnan(share):
            colour = "white" if share > _DARK else "#333333"
            text = "" if round(share, 2) == plain else f"{100 * share:.0f}"
            axes.text(x, y, text, ha="center", va="center", fontsize=6, color=colour)
    if value == RIGHT:
        _outline(axes, cells >= HOLDS)
    _bracket(axes, speeds)


def _outline(axes: Axes, inside: Any) -> None:
    """A line around the cells in which the method holds."""
    rows, columns = inside.shape
    padded = np.pad(inside, 1)
    for y in range(rows + 1):
        for x in range(columns + 1):
            here = padded[y + 1, x + 1]
            if here != padded[y + 1, x] and y < rows:
                axes.plot([x - 0.5, x - 0.5], [y - 0.5, y + 0.5], **_LINE)
            if here != padded[y, x + 1] and x < columns:
                axes.plot([x - 0.5, x + 0.5], [y - 0.5, y - 0.5], **_LINE)


def _bracket(axes: Axes, speeds: Sequence[float]) -> None:
    """The paper's range of speeds, above the map."""
    if len(speeds) > 1 and speeds[0] <= PAPER_PX_S[0] and speeds[-1] >= PAPER_PX_S[1]:
        ends = np.interp(np.log(PAPER_PX_S), np.log(speeds), np.arange(len(speeds)))
        axes.plot(
            ends, [1.012] * 2, transform=axes.get_xaxis_transform(), color="#444444",
            linewidth=3, clip_on=False, solid_capstyle="butt",
        )  # fmt: skip


def _varies(rows: Sequence[Row], factor: str) -> bool:
    return len(levels(rows, factor)) > 1


def _mean_of(crossed: Sequence[str]) -> str:
    return f" (mean of {' and '.join(_short(name) + 's' for name in crossed)})" if crossed else ""


def _short(factor: str) -> str:
    return factor.removesuffix("_px")


def _label(level: Any) -> str:
    return f"{level:g}" if isinstance(level, int | float) else str(level)


def _footnote(figure: Figure, rows: Sequence[Row]) -> None:
    seeds = len(levels(rows, "seed"))
    text = (
        "Share of the 10 ms steps from 100 ms after the target came into view on (a slow one is in "
        "view from the start), mean of "
        f"{seeds} drawing{'s' if seeds > 1 else ''} a cell; no number: all correct, or none wrong. "
        f"Orange: {100 * HOLDS:.0f} % correct or more. Grey bar: the paper's speeds. "
        f"Where not varied: {BASE.length_px}×{BASE.height_px} px, contrast {BASE.contrast:g}, "
        f"{BASE.surface}, {BASE.direction}, {BASE.noise_hz:g} Hz, background {BASE.background}."
    )
    text = textwrap.fill(text, round(_LETTERS_AN_INCH * figure.get_figwidth()))
    figure.supxlabel(text, fontsize=7, x=0.01, ha="left", color="#555555")
