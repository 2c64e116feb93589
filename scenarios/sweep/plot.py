"""The figure of a sweep: one value of its table against the parameters that vary."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenarios.errors import ScenarioError
from scenarios.output.figures import figure_file, literal
from scenarios.pipeline.registry import DETECTORS
from scenarios.sweep.plan import Point

VALUE = "detector.accuracy_after_100ms"
"""Share of correct steps from 100 ms in view on, which is plotted by default."""
MAX_PANELS = 12
"""Most maps in one figure (assumed: as many as can be read)."""
_METHOD, _SEED = "method", "seed"
_PANEL_IN = 4.2, 3.2
Row = Mapping[str, Any]


def check_value(table: Sequence[Row], value: str) -> None:
    """Check that the table has numbers in a column.

    Raises:
        ScenarioError: there is no such column, or it holds no number.
    """
    numeric = [name for name in table[0] if any(_is_number(row[name]) for row in table)]
    if value not in numeric:
        scores = [name for name in numeric if name.startswith(("detector.", "events."))]
        raise ScenarioError(
            f"--plot-value is {value}. Allowed is a column of results.csv with numbers, such as "
            f"{', '.join(scores)}. Choose one of them."
        )


def write_plot(png: Path, points: Sequence[Point], table: Sequence[Row], value: str) -> None:
    """Draw the mean over the seeds of a value, and write the figure as PNG.

    Two parameters give a map for every combination of the others, such as the method. One gives
    a curve for every method.

    Args:
        png: path of the file.
        points: points of the sweep.
        table: one row per point.
        value: column of the table.

    Raises:
        ScenarioError: nothing varies, too much does, or the column has no numbers.
    """
    check_value(table, value)
    rows = [
        dict(p.varied) | dict(p.labels) | {value: row[value]}
        for p, row in zip(points, table, strict=True)
    ]
    axes = _axes(rows, value)
    x, y = axes[0], axes[1] if len(axes) > 1 else None
    panels = _panels(rows, [name for name in _names(rows, value) if name not in axes[:2]])
    if y is not None and len(panels) > MAX_PANELS:
        raise ScenarioError(
            f"The figure would have {len(panels)} maps, one for each combination of "
            f"{', '.join(axes[2:]) or _METHOD}. Allowed is up to {MAX_PANELS}. Vary fewer "
            "parameters, or plot results.csv yourself."
        )
    columns = 1 if y is None else min(3, len(panels))
    lines = 1 if y is None else -(-len(panels) // columns)
    size = (_PANEL_IN[0] * columns + 1.2, _PANEL_IN[1] * lines + 0.3)
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder) / "figure"
        with figure_file(base, size) as figure:
            if y is None:
                _draw_curves(figure, panels, x, value)
            else:
                _draw_maps(figure, panels, (lines, columns), (x, y), value)
        png.write_bytes(base.with_suffix(".png").read_bytes())


def _names(rows: Sequence[Row], value: str) -> list[str]:
    """Return what varies besides the seed, in the order of the file."""
    names = dict.fromkeys(name for row in rows for name in row if name not in (_SEED, value))
    return [name for name in names if len({str(row.get(name)) for row in rows}) > 1]


def _axes(rows: Sequence[Row], value: str) -> list[str]:
    """Return what can be an axis, numbers first."""
    names = _names(rows, value)
    numbers = [name for name in names if all(_is_number(row.get(name)) for row in rows)]
    axes = numbers + [name for name in names if name not in (*numbers, _METHOD)]
    if not axes:
        raise ScenarioError(
            "There is nothing to plot against, because no parameter varies besides method and "
            "seed. Vary one in [grid], [sample] or [[levels]]."
        )
    return axes


def _panels(rows: Sequence[Row], names: Sequence[str]) -> dict[str, list[Row]]:
    """Return the rows of each combination of other parameters, by its title."""
    panels: dict[str, list[Row]] = {}
    for row in rows:
        title = ", ".join(
            str(row.get(name)) if name == _METHOD else f"{name} {_text(row.get(name))}"
            for name in names
        )
        panels.setdefault(title, []).append(row)
    return panels


def _draw_curves(figure: Any, panels: Mapping[str, list[Row]], x: str, value: str) -> None:
    axes = figure.subplots()
    levels = _levels([row for rows in panels.values() for row in rows], x)
    is_number = all(map(_is_number, levels))
    for title, rows in panels.items():
        means = [_mean([row[value] for row in rows if row.get(x) == level]) for level in levels]
        entry = DETECTORS.get(title)
        style = {"color": entry.colour, "marker": entry.marker} if entry else {"marker": "o"}
        places = levels if is_number else range(len(levels))
        axes.plot(places, means, label=literal(entry.label if entry else title), **style)
    if not is_number:
        axes.set_xticks(range(len(levels)), [literal(_text(level)) for level in levels])
    elif _spans_decades(levels):
        axes.set_xscale("log")
    axes.set_xlabel(literal(x))
    axes.set_ylabel(literal(value))
    if len(panels) > 1:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def _draw_maps(
    figure: Any,
    panels: Mapping[str, list[Row]],
    grid: tuple[int, int],
    names: tuple[str, str],
    value: str,
) -> None:
    rows = [row for found in panels.values() for row in found]
    xs, ys = (_levels(rows, name) for name in names)
    maps = [_map(found, names, (xs, ys), value) for found in panels.values()]
    shown = np.concatenate([m[np.isfinite(m)] for m in maps])
    limits = (0.0, 1.0) if "accuracy" in value else (float(shown.min()), float(shown.max()))
    all_axes = figure.subplots(*grid, squeeze=False)
    for axes in all_axes.flat[len(panels) :]:
        axes.set_visible(False)
    for axes, title, cells in zip(all_axes.flat, panels, maps, strict=False):
        image = axes.pcolormesh(cells, cmap="viridis", vmin=limits[0], vmax=limits[1])
        axes.set_facecolor("0.85")
        axes.set_xticks(np.arange(len(xs)) + 0.5, [literal(_text(level)) for level in xs])
        axes.set_yticks(np.arange(len(ys)) + 0.5, [literal(_text(level)) for level in ys])
        axes.set_xlabel(literal(names[0]))
        axes.set_ylabel(literal(names[1]))
        entry = DETECTORS.get(title)
        axes.set_title(literal(entry.label if entry else title))
        _write_values(axes, cells, limits)
    figure.colorbar(image, ax=all_axes, label=literal(f"{value} (grey: no value)"))


def _map(
    rows: Sequence[Row],
    names: tuple[str, str],
    levels: tuple[list[Any], list[Any]],
    value: str,
) -> npt.NDArray[np.float64]:
    cells = np.full((len(levels[1]), len(levels[0])), np.nan)
    for i, j in np.ndindex(cells.shape):
        place = levels[0][j], levels[1][i]
        found = [row[value] for row in rows if (row.get(names[0]), row.get(names[1])) == place]
        cells[i, j] = _mean(found)
    return cells


def _write_values(axes: Any, cells: npt.NDArray[np.float64], limits: tuple[float, float]) -> None:
    middle = sum(limits) / 2
    for (i, j), number in np.ndenumerate(cells):
        if np.isfinite(number):
            colour = "white" if number < middle else "black"
            axes.text(j + 0.5, i + 0.5, f"{number:.3g}", color=colour, ha="center", va="center")


def _levels(rows: Sequence[Row], name: str) -> list[Any]:
    """Return the values of a parameter: numbers in ascending order, others as in the file."""
    levels = list(dict.fromkeys(row.get(name) for row in rows))
    return sorted(levels) if all(map(_is_number, levels)) else levels


def _mean(values: Sequence[Any]) -> float:
    numbers = [float(value) for value in values if _is_number(value)]
    return float(np.mean(numbers)) if numbers else float("nan")


def _spans_decades(levels: Sequence[float]) -> bool:
    return min(levels) > 0 and max(levels) / min(levels) >= 20


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _text(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
