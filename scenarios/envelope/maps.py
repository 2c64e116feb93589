"""Maps of an envelope: speed on x, another factor on y, the share of steps as colour."""

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
    CORRECT,
    F64,
    MIN_CORRECT,
    NONE,
    OPPOSITE,
    Row,
    at_base_point,
    levels,
    mean_by_cell,
    worst_level,
)
from scenarios.output.figures import figure_file

_VALUES = {
    CORRECT: "share of steps with the correct direction, %",
    OPPOSITE: "share of steps with the opposite direction, %",
    NONE: "share of steps without a direction, %",
}
_COLOURS = {
    CORRECT: mpl.colormaps["YlGnBu"],
    OPPOSITE: LinearSegmentedColormap.from_list("wrong", ["white", "#f4a582", "#b2182b"]),
    NONE: LinearSegmentedColormap.from_list("silent", ["white", "#222222"]),
}
_DARK = 0.6
"""Share above which a cell is dark, so that its number is white."""
_CHARACTERS_PER_INCH = 17
"""Width of the footnote's text, in 7 points."""
_LINE: Any = {
    "color": "#e4572e",
    "linewidth": 1.8,
    "clip_on": False,
    "solid_capstyle": "projecting",
}
PAPER_PX_S = (347.0, 784.0)
"""Range of speeds of the paper's eight sequences: 1.07 to 2.42 rad/s at 324 px per radian."""
_NAMES = {
    SPEED: "image speed [px/s]",
    NOISE: "noise per pixel [Hz]",
    "contrast": "contrast [SD of ln L]",
    "direction": "direction",
    "length_px": "length of the target [px]",
    "surface": "surface of the target",
    "background": "motion in the background",
}


def draw_method(path: Path, rows: Sequence[Row], value: str, *, crossed: Sequence[str]) -> None:
    """Draw one result of one method: by speed and noise, and by speed and every other factor.

    Args:
        path: path of the figure, without a suffix.
        rows: rows of one method.
        value: the result, a share of the steps: `CORRECT`, `OPPOSITE` or `NONE`.
        crossed: factors whose levels are averaged in the map of speed and noise.
    """
    factors = [name for name in _NAMES if name not in (SPEED, NOISE) and _varies(rows, name)]
    columns = min(3, 1 + len(factors))
    lines = -(-(1 + len(factors)) // columns)
    with figure_file(path, (0.4 + 4.3 * columns, 1.0 + 2.9 * lines)) as figure:
        figure.suptitle(f"{rows[0]['method']}: {_VALUES[value]}", x=0.01, ha="left")
        first, *others = figure.subplots(lines, columns, squeeze=False).ravel()
        full = at_base_point(rows, (SPEED, NOISE, *crossed))
        draw_map(first, full, NOISE, value, title=f"by noise{_mean_of(crossed)}")
        for axes, factor in zip(others, factors, strict=False):
            own = at_base_point(rows, (SPEED, factor))
            draw_map(axes, own, factor, value, title=f"by {_short(factor)}")
        for axes in others[len(factors) :]:
            axes.remove()
        _footnote(figure, rows)


def draw_comparison(path: Path, rows: Sequence[Row], *, crossed: Sequence[str]) -> None:
    """Draw all methods side by side: correct steps by speed and noise, mean and worst level."""
    methods = levels(rows, "method")
    with figure_file(path, (4.4 * len(methods) + 0.4, 3.2 + 3.0 * len(crossed))) as figure:
        grid = figure.subplots(1 + len(crossed), len(methods), squeeze=False)
        for column, method in enumerate(methods):
            own = [row for row in rows if row["method"] == method]
            own = at_base_point(own, (SPEED, NOISE, *crossed))
            title = f"{method}: correct, %{_mean_of(crossed)}"
            draw_map(grid[0, column], own, NOISE, CORRECT, title=title)
            for axes, factor in zip(grid[1:, column], crossed, strict=True):
                lowest = worst_level(own, SPEED, NOISE, factor, CORRECT)
                _draw_cells(axes, own, NOISE, CORRECT, lowest)
                axes.set_title(f"{method}: worst {_short(factor)}", pad=9)
        _footnote(figure, rows)


def draw_levels(path: Path, rows: Sequence[Row], factor: str) -> None:
    """Draw speed × noise for every level of a crossed factor, one row of maps per method."""
    methods, measured = levels(rows, "method"), levels(rows, factor)
    size = 3.3 * len(measured) + 0.4, 2.9 * len(methods) + 0.5
    with figure_file(path, size) as figure:
        grid = figure.subplots(len(methods), len(measured), squeeze=False)
        for line, method in zip(grid, methods, strict=True):
            for axes, level in zip(line, measured, strict=True):
                own = [r for r in rows if r["method"] == method and r[factor] == level]
                own = at_base_point(own, (SPEED, NOISE, factor))
                title = f"{method}: correct, {_short(factor)} {level}"
                draw_map(axes, own, NOISE, CORRECT, title=title)
        _footnote(figure, rows)


def draw_map(axes: Axes, rows: Sequence[Row], factor: str, value: str, *, title: str) -> None:
    """Draw one map: a result by speed and another factor, averaged over everything else."""
    _draw_cells(axes, rows, factor, value, mean_by_cell(rows, SPEED, factor, value))
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
    ideal = 1 if value == CORRECT else 0
    for (y, x), share in np.ndenumerate(cells):
        if not np.isnan(share):
            colour = "white" if share > _DARK else "#333333"
            text = "" if round(share, 2) == ideal else f"{100 * share:.0f}"
            axes.text(x, y, text, ha="center", va="center", fontsize=6, color=colour)
    if value == CORRECT:
        _draw_outline(axes, cells >= MIN_CORRECT)
    _draw_paper_range(axes, speeds)


def _draw_outline(axes: Axes, inside: Any) -> None:
    """Draw a line around the cells where enough steps are correct."""
    rows, columns = inside.shape
    padded = np.pad(inside, 1)
    for y in range(rows + 1):
        for x in range(columns + 1):
            here = padded[y + 1, x + 1]
            if here != padded[y + 1, x] and y < rows:
                axes.plot([x - 0.5, x - 0.5], [y - 0.5, y + 0.5], **_LINE)
            if here != padded[y, x + 1] and x < columns:
                axes.plot([x - 0.5, x + 0.5], [y - 0.5, y - 0.5], **_LINE)


def _draw_paper_range(axes: Axes, speeds: Sequence[float]) -> None:
    """Draw a bar for the paper's range of speeds above the map."""
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
        "Share of the 10 ms steps at least 100 ms after the target came into view (a slow target "
        "is in view from the start). Each cell is the mean of "
        f"{seeds} repetition{'s' if seeds > 1 else ''}; a cell without a number has no errors. "
        f"Orange: at least {100 * MIN_CORRECT:.0f} % correct. Grey bar: the paper's speeds. "
        f"Other factors: {BASE.length_px}×{BASE.height_px} px, contrast {BASE.contrast:g}, "
        f"{BASE.surface}, {BASE.direction}, {BASE.noise_hz:g} Hz, background {BASE.background}."
    )
    text = textwrap.fill(text, round(_CHARACTERS_PER_INCH * figure.get_figwidth()))
    figure.supxlabel(text, fontsize=7, x=0.01, ha="left", color="#555555")
