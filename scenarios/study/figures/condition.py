"""Images and responses at each velocity, in one lighting (paper, Fig. EX1 and EX2)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

from scenarios.output.figures import figure_file
from scenarios.pipeline.registry import DETECTORS, Family
from scenarios.study.figures.response_panels import (
    draw_response,
    draw_velocity,
    response_handles,
    velocity_handles,
)
from scenarios.study.figures.sequence_axis import wrap_label
from scenarios.study.figures.snapshot_panels import (
    draw_aps,
    draw_saliency,
    region_handle,
    truth_box_handle,
    white_level_dn,
)
from scenarios.study.results import SequenceResult
from scenarios.styles.method_style import method_style

Draw = Callable[[Axes, SequenceResult], None]

_PANELS = (Family.EVENT_FLY, Family.FRAME_FLY, Family.VELOCITY)
_COLUMN_IN = 1.72
_ROW_IN = 1.2
_IMAGE_ROW_IN = 1.34


def draw_condition(path: Path, sequences: Sequence[SequenceResult]) -> None:
    """Draw a column for each velocity: APS frame, saliency, and responses over time.

    The responses are those of the first method of each family that ran; a family without a run has
    no row.

    Args:
        path: path of the figure, without a suffix.
        sequences: one result or more in one lighting, sorted by velocity.
    """
    rows = _rows(sequences)
    size = (0.95 + _COLUMN_IN * max(len(sequences), 2), 1.1 + sum(row.height_in for row in rows))
    with figure_file(path, size) as figure:
        heights = [row.height_in for row in rows]
        grid = figure.subplots(len(rows), len(sequences), squeeze=False, height_ratios=heights)
        for line, row in zip(grid, rows, strict=True):
            for axes, sequence in zip(line, sequences, strict=True):
                row.draw(axes, sequence)
            _label_row(line, row, is_last=row is rows[-1])
        for axes, sequence in zip(grid[0], sequences, strict=True):
            axes.set_title(_heading(sequence), loc="center", fontsize=9)
        if rows[-1].is_over_time:
            for axes in grid[-1]:
                axes.set_xlabel("time in view [s]")
        _add_legend(figure, rows, columns=min(5, grid.shape[1] + 1))


@dataclass(frozen=True)
class _Row:
    """One row of panels; it has a letter if a panel of the paper starts there."""

    letter: str
    name: str
    draw: Draw
    handles: Sequence[Line2D]
    height_in: float = _ROW_IN

    @property
    def is_over_time(self) -> bool:
        return self.height_in == _ROW_IN


def _rows(sequences: Sequence[SequenceResult]) -> list[_Row]:
    rows = [
        _Row(
            "A",
            "APS frame",
            partial(draw_aps, white_dn=white_level_dn(sequences)),
            [truth_box_handle()],
            _IMAGE_ROW_IN,
        ),
        _Row("", "saliency", draw_saliency, [region_handle()], _IMAGE_ROW_IN),
    ]
    fly, frame_fly, velocity = (_first_of_family(family, sequences) for family in _PANELS)
    for letter, method in (("", fly), ("B", frame_fly)):
        if method is not None:
            draw, style = partial(draw_response, method=method), method_style(method)
            rows.append(_Row(letter, f"{style.label}\nHS, VS [1]", draw, response_handles(style)))
    if velocity is not None:
        top = max(one.image_speed_px_s for one in sequences)
        draw, style = partial(draw_velocity, method=velocity, top_px_s=top), method_style(velocity)
        rows.append(_Row("C", f"{wrap_label(style.label)}\n[px/s]", draw, velocity_handles(style)))
    return rows


def _first_of_family(family: Family, sequences: Sequence[SequenceResult]) -> str | None:
    """Return the first method of a family that ran."""
    ran = {run.method for sequence in sequences for run in sequence.runs}
    ours = (entry.name for entry in DETECTORS.values() if entry.family is family)
    return next((method for method in ours if method in ran), None)


def _label_row(line: Sequence[Axes], row: _Row, *, is_last: bool) -> None:
    line[0].set_ylabel(row.name, fontsize=8)
    for axes in line:
        axes.tick_params(labelbottom=is_last, labelsize=8)
        axes.label_outer()
    if row.letter:
        line[0].annotate(
            row.letter,
            (0, 1),
            xytext=(-46, 2),
            xycoords="axes fraction",
            textcoords="offset points",
            fontweight="bold",
            fontsize=12,
        )


def _add_legend(figure: Figure, rows: Sequence[_Row], *, columns: int) -> None:
    """Add a legend with one entry for each label, which shows the colours of all methods."""
    shown: dict[str, list[Line2D]] = {}
    for handle in (handle for row in rows for handle in row.handles):
        shown.setdefault(str(handle.get_label()), []).append(handle)
    entries: Any = [tuple(_one_per_colour(handles)) for handles in shown.values()]
    figure.legend(
        entries,
        list(shown),
        handler_map={tuple: HandlerTuple(ndivide=None)},
        loc="outside lower center",
        ncols=columns,
        fontsize=8,
    )


def _one_per_colour(handles: Sequence[Line2D]) -> list[Line2D]:
    return list({str(handle.get_color()): handle for handle in handles}.values())


def _heading(sequence: SequenceResult) -> str:
    return (
        f"{sequence.omega_rad_s:.2f} rad/s\n"
        f"{sequence.speed_km_h:.0f} km/h, {sequence.image_speed_px_s:.0f} px/s"
    )
