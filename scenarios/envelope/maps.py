"""Maps of an envelope: speed on x, another factor on y, the share of steps as colour."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from scenarios.envelope.grid import BASE, NOISE, SPEED, SURFACE, TILT
from scenarios.envelope.stimulus import BAR_PX
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
from scenarios.output.figures import figure_file, literal
from scenarios.styles.method_style import method_style

_VALUES = {
    CORRECT: "share of steps with the correct direction, %",
    OPPOSITE: "share of steps with the opposite direction, %",
    NONE: "share of steps without a direction, %",
}
_NO_STEP = "#c9c9c9"
"""Colour of a cell without any step."""
_COLOURS = {
    CORRECT: mpl.colormaps["YlGnBu"].with_extremes(bad=_NO_STEP),
    OPPOSITE: LinearSegmentedColormap.from_list(
        "wrong", ["white", "#f4a582", "#b2182b"]
    ).with_extremes(bad=_NO_STEP),
    NONE: LinearSegmentedColormap.from_list("silent", ["white", "#222222"]).with_extremes(
        bad=_NO_STEP
    ),
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
    SURFACE: "surface of the target",
    "background": "motion in the background",
    TILT: "tilt of the target [deg]",
    "events_per_edge": "events per edge and pixel",
}


def draw_method(path: Path, rows: Sequence[Row], value: str, *, crossed: Sequence[str]) -> None:
    """Draw one result of one method: by speed and noise, and by speed and every other factor.

    Args:
        path: path of the figure, without a suffix.
        rows: rows of one method.
        value: the result, a share of the steps: `CORRECT`, `OPPOSITE` or `NONE`.
        crossed: factors whose levels are averaged in the map of speed and noise.
    """
    maps = list(_factor_maps(rows))
    columns = min(4, 1 + len(maps))
    lines = -(-(1 + len(maps)) // columns)
    with figure_file(path, (0.4 + 4.3 * columns, 1.0 + 2.9 * lines)) as figure:
        figure.suptitle(f"{_name(rows[0]['method'])}: {_VALUES[value]}", x=0.01, ha="left")
        first, *others = panels = figure.subplots(lines, columns, squeeze=False).ravel()
        full = at_base_point(rows, (SPEED, NOISE, *crossed))
        draw_map(first, full, NOISE, value, title=f"by noise{_mean_of(crossed)}")
        for axes, (factor, own, title) in zip(others, maps, strict=False):
            draw_map(axes, own, factor, value, title=title)
        for axes in others[len(maps) :]:
            axes.remove()
        _colour_bar(figure, panels[: 1 + len(maps)], value)
        _footnote(figure, rows)


def _factor_maps(rows: Sequence[Row]) -> Iterator[tuple[str, list[Row], str]]:
    """Yield a factor, the rows to average by speed and this factor, and a title for each map."""
    for factor in (name for name in _NAMES if name not in (SPEED, NOISE) and _varies(rows, name)):
        yield factor, at_base_point(rows, (SPEED, factor)), f"by {_short(factor)}"
        if factor == TILT:
            free = at_base_point(rows, (SPEED, TILT, SURFACE))
            for surface in levels(free, SURFACE):
                own = [row for row in free if row[SURFACE] == surface]
                if surface != BASE.surface and _varies(own, TILT):
                    yield factor, own, f"by tilt of a {surface}"


def draw_comparison(path: Path, rows: Sequence[Row], *, crossed: Sequence[str]) -> None:
    """Draw all methods side by side: correct steps by speed and noise, mean and worst level."""
    methods = levels(rows, "method")
    with figure_file(path, (4.4 * len(methods) + 0.4, 3.2 + 3.0 * len(crossed))) as figure:
        grid = figure.subplots(1 + len(crossed), len(methods), squeeze=False)
        for column, method in enumerate(methods):
            own = [row for row in rows if row["method"] == method]
            own = at_base_point(own, (SPEED, NOISE, *crossed))
            title = f"{_name(method)}\ncorrect, %{_mean_of(crossed)}"
            draw_map(grid[0, column], own, NOISE, CORRECT, title=title)
            for axes, factor in zip(grid[1:, column], crossed, strict=True):
                lowest = worst_level(own, SPEED, NOISE, factor, CORRECT)
                _draw_cells(axes, own, NOISE, CORRECT, lowest)
                axes.set_title(f"{_name(method)}\nworst {_short(factor)}", pad=9)
        _colour_bar(figure, grid.ravel(), CORRECT)
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
                title = f"{_name(method)}\ncorrect, {_short(factor)} {level}"
                draw_map(axes, own, NOISE, CORRECT, title=title)
        _colour_bar(figure, grid.ravel(), CORRECT)
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
    for (y, x), share in np.ndenumerate(cells):
        if not np.isnan(share):
            colour = "white" if share > _DARK else "#333333"
            axes.text(
                x, y, f"{100 * share:.0f}", ha="center", va="center", fontsize=6, color=colour
            )
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


def _name(method: str) -> str:
    return literal(method_style(method).label)


def _varies(rows: Sequence[Row], factor: str) -> bool:
    return len(levels(rows, factor)) > 1


def _mean_of(crossed: Sequence[str]) -> str:
    return f" (mean of {' and '.join(_short(name) + 's' for name in crossed)})" if crossed else ""


def _short(factor: str) -> str:
    return factor.removesuffix("_px").removesuffix("_deg").replace("_", " ")


def _label(level: Any) -> str:
    return f"{level:g}" if isinstance(level, int | float) else str(level)


def _colour_bar(figure: Figure, panels: Iterable[Axes], value: str) -> None:
    """Draw the scale of the colours beside the maps."""
    scale = ScalarMappable(Normalize(0, 100), _COLOURS[value])
    bar = figure.colorbar(scale, ax=list(panels), shrink=0.7, aspect=30, pad=0.02)
    bar.set_label("steps, %", fontsize=8)
    bar.ax.tick_params(labelsize=8, length=0)
    bar.outline.set_visible(False)


def _footnote(figure: Figure, rows: Sequence[Row]) -> None:
    seeds = len(levels(rows, "seed"))
    text = (
        "Share of the 10 ms steps at least 100 ms after the target came into view (a slow target "
        "is in view from the start). Each cell is the mean of "
        f"{seeds} repetition{'s' if seeds > 1 else ''}. A grey cell without a number has no step. "
        f"Orange line: at least {100 * MIN_CORRECT:.0f} % correct. Grey bar: the paper's speeds. "
        f"Other factors: {BASE.length_px}×{BASE.height_px} px, contrast {BASE.contrast:g}, "
        f"{BASE.surface}, {BASE.direction}, {BASE.noise_hz:g} Hz, background {BASE.background}, "
        f"tilt {BASE.tilt_deg:g}°, {BASE.events_per_edge} events per edge. A bar is "
        f"{BASE.length_px}×{BAR_PX} px along its path; a band crosses the whole image."
    )
    text = textwrap.fill(text, round(_CHARACTERS_PER_INCH * figure.get_figwidth()))
    figure.supxlabel(text, fontsize=7, x=0.01, ha="left", color="#555555")
