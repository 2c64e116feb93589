"""Scenes with a moving background, and what each method answers there; not in the paper."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from statistics import fmean

from matplotlib.axes import Axes
from matplotlib.patches import Patch

from scenarios.output.figures import figure_file
from scenarios.study.figures.response_panels import NO_DECISION, WRONG
from scenarios.study.figures.sequence_axis import methods_of
from scenarios.study.figures.snapshot_panels import (
    draw_aps,
    draw_saliency,
    region_handle,
    truth_box_handle,
    white_level_dn,
)
from scenarios.study.results import SequenceResult
from scenarios.study.rows import Row, study_rows
from scenarios.study.statistics import select
from scenarios.styles.method_style import method_style

_COLUMN_IN, _LABELS_IN, _IMAGE_IN, _BAR_IN = 1.5, 2.2, 1.15, 0.17
_RIGHT = "#8a8a8a"
"""Colour of right steps in the legend; in the bars it is that of the method."""


def draw_background(path: Path, sequences: Sequence[SequenceResult]) -> None:
    """Draw a column for each background: APS frame, saliency, and a bar for each method.

    Args:
        path: path of the figure, without a suffix.
        sequences: one result or more with a moving background, by day, at night or both.
    """
    lightings = list(dict.fromkeys(one.lighting for one in sequences))
    backgrounds = list(dict.fromkeys(one.background for one in sequences))
    methods = methods_of(sequences)
    heights = [_IMAGE_IN, _IMAGE_IN, 0.5 + _BAR_IN * len(methods)] * len(lightings)
    size = (_LABELS_IN + _COLUMN_IN * len(backgrounds), 0.7 + sum(heights))
    with figure_file(path, size) as figure:
        grid = figure.subplots(len(heights), len(backgrounds), squeeze=False, height_ratios=heights)
        for number, lighting in enumerate(lightings):
            lines = grid[3 * number : 3 * number + 3]
            own = [one for one in sequences if one.lighting == lighting]
            for column, background in enumerate(backgrounds):
                found = [one for one in own if one.background == background]
                _draw_column(lines[:, column], found, methods, white_dn=white_level_dn(own))
                lines[0, column].set_title(f"{background}, {lighting}", loc="center", fontsize=9)
            for axes in lines[2, 1:]:
                axes.set_yticklabels([])
        handles = [truth_box_handle(), region_handle()]
        bars = [
            Patch(color=colour, label=label)
            for colour, label in ((_RIGHT, "right"), (WRONG, "wrong"), (NO_DECISION, "none"))
        ]
        figure.legend(handles=[*handles, *bars], loc="outside lower center", ncols=5, fontsize=8)


def _draw_column(
    line: Iterable[Axes],
    sequences: Sequence[SequenceResult],
    methods: Sequence[str],
    *,
    white_dn: float,
) -> None:
    """Draw one sequence in the three panels of a column; without one, the panels are removed."""
    if not sequences:
        for axes in line:
            axes.remove()
        return
    (sequence,) = sequences
    frame, saliency, bars = line
    draw_aps(frame, sequence, white_dn=white_dn)
    draw_saliency(saliency, sequence)
    _draw_bars(bars, study_rows([sequence]), methods)


def _draw_bars(axes: Axes, rows: Sequence[Row], methods: Sequence[str]) -> None:
    """Draw the shares of right, wrong and missing directions of each method, over the seeds."""
    for at, method in enumerate(methods):
        own = select(rows, method=method)
        found = [_known(own, name) for name in ("accuracy_after_100ms", "none_after_100ms")]
        if not all(found):  # a frame rate so low that there is no settled step
            axes.text(1, at, "no step", fontsize=7, va="center", color="#666666")
            continue
        right, none = (100 * fmean(known) for known in found)
        wrong = max(100.0 - right - none, 0.0)
        axes.barh(at, right, 0.8, color=method_style(method).colour)
        axes.barh(at, wrong, 0.8, left=right, color=WRONG)
        axes.barh(at, none, 0.8, left=right + wrong, color=NO_DECISION)
    axes.set(xlim=(0, 100), xticks=(0, 50, 100), ylim=(len(methods) - 0.5, -0.5))
    axes.set_yticks(range(len(methods)), [method_style(method).label for method in methods])
    axes.set_xlabel("steps [%]", fontsize=8)
    axes.tick_params(labelsize=7, length=0)
    axes.spines[:].set_visible(False)


def _known(rows: Sequence[Row], column: str) -> list[float]:
    return [float(row[column]) for row in rows if row[column] is not None]
