"""The figure of `flybench detect`: events at the strongest estimate, responses and event rate."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from flybench.direction import Direction
from flybench.memory import check_memory
from scenarios.detect.plot_data import DIRECTIONS, SNAPSHOT_US, PlotData, Snapshot
from scenarios.detect.verdict import RecordingVerdict
from scenarios.output.colours import OFF, ON, hex_of
from scenarios.output.figures import figure_file, literal
from scenarios.output.numbers import counted
from scenarios.styles.method_style import MethodStyle, method_style

SIZE_IN = (11.0, 6.4)
VS = "#80868e"
_REGION_PT = 1.8
_BYTES_PER_PX = 95
"""Memory for a pixel of the sensor: image, APS frame and their copies (measured: 93)."""
DIRECTION_COLOUR = {
    Direction.RIGHT: "#a9dcc9",
    Direction.LEFT: "#eab8d8",
    Direction.UP: "#e6dc9a",
    Direction.DOWN: "#c9c5ec",
}
"""Pale backgrounds, unlike ON and OFF: green, pink, yellow, violet."""


def write_plot(
    png: Path,
    data: PlotData,
    size: tuple[int, int],
    name: str,
    verdict: RecordingVerdict,
    *,
    method: str,
) -> None:
    """Draw the figure and write it as PNG.

    Args:
        png: path of the file, in an existing folder.
        data: data of the recording.
        size: sensor columns and rows [px].
        name: name of the recording and the method, for the title.
        verdict: verdict on the recording.
        method: name of the method, which gives the colour of its region and its response.

    Raises:
        MemoryBudgetError: the image of the sensor needs more memory than the budget allows.
    """
    width, height = size
    check_memory(f"A figure of {width}×{height} px", _BYTES_PER_PX * width * height)
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder) / "figure"
        with figure_file(base, SIZE_IN) as figure:
            _draw(figure, data, size, name, verdict, method_style(method))
        png.write_bytes(base.with_suffix(".png").read_bytes())


def _draw(
    figure: Any,
    data: PlotData,
    size: tuple[int, int],
    name: str,
    verdict: RecordingVerdict,
    style: MethodStyle,
) -> None:
    figure.suptitle(f"{literal(name)}: {verdict.word}\n{verdict.reason}", ha="left", x=0.01)
    top, bottom = figure.subfigures(2, 1, height_ratios=(1.25, 1.0))
    has_frame = data.snapshot.frame is not None
    images = top.subplots(1, 2 if has_frame else 1, squeeze=False)[0]
    _draw_events(images[0], data.snapshot, size, style)
    if has_frame:
        _draw_frame(images[1], data.snapshot, size)
    response, rate = bottom.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    _draw_responses(response, data, verdict, style)
    _draw_rates(rate, data)


def _draw_events(axes: Any, snapshot: Snapshot, size: tuple[int, int], style: MethodStyle) -> None:
    width, height = size
    image = np.ones((height, width, 3))
    events = snapshot.events
    for polarity, colour in ((False, OFF), (True, ON)):
        of_polarity = events[events["p"] == polarity]
        image[of_polarity["y"], of_polarity["x"]] = np.array(colour) / 255
    axes.imshow(image, interpolation="nearest", extent=(0, width, height, 0))
    label = "last events"
    handles = [
        Line2D([], [], ls="none", marker="s", color=hex_of(colour), label=name)
        for colour, name in ((ON, "ON"), (OFF, "OFF"))
    ]
    if snapshot.estimate is not None:
        t_s = snapshot.estimate.t_us * 1e-6
        label = f"events up to {t_s:.2f} s: {snapshot.estimate.direction.value}"
        handles += _draw_region(axes, snapshot, style)
    axes.set_title(f"{label} ({SNAPSHOT_US // 1000} ms)")
    _pixel_axes(axes, size)
    axes.legend(handles=handles, loc="center right", bbox_to_anchor=(-0.16, 0.5))


def _draw_region(axes: Any, snapshot: Snapshot, style: MethodStyle) -> list[Line2D]:
    """Draw the region of interest; return its legend entry, or none without a region."""
    assert snapshot.estimate is not None
    box = snapshot.estimate.roi_px
    if box is None:
        return []
    x0, y0, x1, y1 = box
    axes.add_patch(
        Rectangle(
            (x0, y0), x1 - x0, y1 - y0, fill=False, edgecolor=style.colour, linewidth=_REGION_PT
        )
    )
    label = "region of interest\nof the method"
    return [Line2D([], [], color=style.colour, linewidth=_REGION_PT, label=label)]


def _pixel_axes(axes: Any, size: tuple[int, int]) -> None:
    """Label the axes of an image: pixels from the upper left corner."""
    width, height = size
    axes.set(xticks=(0, width), yticks=(0, height), xlabel="x [px]", ylabel="y [px]")


def _draw_frame(axes: Any, snapshot: Snapshot, size: tuple[int, int]) -> None:
    assert snapshot.frame is not None
    image = snapshot.frame.image
    extent, white = (0, size[0], size[1], 0), max(1, image.max())
    axes.imshow(image, cmap="gray", interpolation="nearest", vmin=0, vmax=white, extent=extent)
    axes.set_title(f"APS frame at {snapshot.frame.end_us * 1e-6:.2f} s")
    _pixel_axes(axes, size)


def _draw_responses(
    axes: Any, data: PlotData, verdict: RecordingVerdict, style: MethodStyle
) -> None:
    times_s = np.asarray(data.t_us) * 1e-6
    _shade_directions(axes, times_s, np.asarray(data.direction))
    _outline_spans(axes, verdict)
    axes.set_title(f"{counted(verdict.steps, 'step')}: {verdict.shares_text}")
    axes.plot(times_s, np.asarray(data.hs), color=style.colour, label="HS, rightward > 0")
    axes.plot(times_s, np.asarray(data.vs), color=VS, label="VS, downward > 0")
    axes.axhline(0.0, color="0.7", linewidth=0.8, zorder=0)
    axes.set_ylim(*_response_limits(data))
    axes.set_ylabel("response [1]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def _response_limits(data: PlotData) -> tuple[float, float]:
    """Return the range of the axis: the greatest response and a tenth more, both ways."""
    responses = np.abs(np.concatenate([np.asarray(data.hs), np.asarray(data.vs)]))
    greatest = float(responses.max(initial=0.0)) or 1.0
    return -1.1 * greatest, 1.1 * greatest


def _shade_directions(axes: Any, times_s: Any, directions: Any) -> None:
    """Shade the periods in which estimates name a direction."""
    if times_s.size < 2:
        return
    step_s = float(np.median(np.diff(times_s)))
    cuts = np.flatnonzero(np.diff(directions) | (np.diff(times_s) > 1.5 * step_s)) + 1
    in_legend: set[Direction] = set()
    for period in np.split(np.arange(directions.size), cuts):
        direction = DIRECTIONS[directions[period[0]]]
        if direction is Direction.NONE:
            continue
        label = None if direction in in_legend else direction.value
        in_legend.add(direction)
        axes.axvspan(
            times_s[period[0]] - step_s,
            times_s[period[-1]],
            color=DIRECTION_COLOUR[direction],
            alpha=0.6,
            linewidth=0,
            label=label,
        )


def _outline_spans(axes: Any, verdict: RecordingVerdict) -> None:
    for number, span in enumerate(verdict.spans):
        axes.axvspan(
            span.from_us * 1e-6,
            span.to_us * 1e-6,
            fill=False,
            edgecolor="0.35",
            label=None if number else "spans of one direction",
        )


def _draw_rates(axes: Any, data: PlotData) -> None:
    times_s, (on, off) = data.rates()
    axes.plot(times_s, on * 1e-3, color=hex_of(ON), label="ON")
    axes.plot(times_s, off * 1e-3, color=hex_of(OFF), label="OFF")
    axes.set_ylim(bottom=0)
    axes.set_ylabel("events\n[1000/s]")
    axes.set_xlabel("time [s]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
