"""The figure of `flybench detect`: what was seen, what was said of it, and how much there was."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.patches import Rectangle

from flybench.direction import Direction
from scenarios.detect.tally import PICTURE_US, WAYS, Curves, Picture, Verdict
from scenarios.output.figures import figure_file

SIZE_IN = (11.0, 6.4)
ON, OFF, HS, VS = "#d7301f", "#1b9e77", "#1f6eb4", "#8e5ac8"
WAY_COLOUR = {
    Direction.RIGHT: "#9ecae1",
    Direction.LEFT: "#fdbe85",
    Direction.UP: "#cbb8e8",
    Direction.DOWN: "#a6dba0",
}


def write_plot(
    png: Path, curves: Curves, verdict: Verdict, size: tuple[int, int], title: str
) -> None:
    """Draw it into a PNG.

    Args:
        png: where to; its folder is there.
        curves: of the recording.
        verdict: of the recording.
        size: sensor columns and rows [px].
        title: what stands above.
    """
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder) / "figure"
        with figure_file(base, SIZE_IN) as figure:
            _draw(figure, curves, verdict, size, title)
        png.write_bytes(base.with_suffix(".png").read_bytes())


def _draw(figure: Any, curves: Curves, verdict: Verdict, size: tuple[int, int], title: str) -> None:
    figure.suptitle(f"{title}: {verdict.direction.value}", ha="left", x=0.01)
    above, below = figure.subfigures(2, 1, height_ratios=(1.25, 1.0))
    with_frame = curves.picture.frame is not None
    images = above.subplots(1, 2 if with_frame else 1, squeeze=False)[0]
    _draw_events(images[0], curves.picture, size)
    if with_frame:
        _draw_frame(images[1], curves.picture)
    response, rate = below.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    _draw_responses(response, curves)
    _draw_rates(rate, curves)


def _draw_events(axes: Any, picture: Picture, size: tuple[int, int]) -> None:
    width, height = size
    image = np.ones((height, width, 3))
    events = picture.events
    for polarity, colour in ((False, OFF), (True, ON)):
        own = events[events["p"] == polarity]
        image[own["y"], own["x"]] = to_rgb(colour)
    axes.imshow(image, interpolation="nearest", extent=(0, width, height, 0))
    told = "the last events"
    if picture.estimate is not None:
        t_s = picture.estimate.t_us * 1e-6
        told = f"events to {t_s:.2f} s: {picture.estimate.direction.value}"
        _draw_region(axes, picture)
    axes.set_title(f"{told} ({PICTURE_US // 1000} ms; ON red, OFF green)")
    axes.set_xticks([0, width])
    axes.set_yticks([0, height])


def _draw_region(axes: Any, picture: Picture) -> None:
    assert picture.estimate is not None
    box = picture.estimate.roi_px
    if box is not None:
        x0, y0, x1, y1 = box
        outline = Rectangle((x0, y0), x1 - x0, y1 - y0, fill=False, edgecolor=HS, linewidth=1.5)
        axes.add_patch(outline)


def _draw_frame(axes: Any, picture: Picture) -> None:
    assert picture.frame is not None
    image = picture.frame.image
    axes.imshow(image, cmap="gray", interpolation="nearest", vmin=0, vmax=max(1, image.max()))
    axes.set_title(f"the frame of {picture.frame.end_us * 1e-6:.2f} s")
    axes.set_xticks([])
    axes.set_yticks([])


def _draw_responses(axes: Any, curves: Curves) -> None:
    times_s = np.asarray(curves.t_us) * 1e-6
    _draw_lanes(axes, times_s, np.asarray(curves.direction))
    axes.plot(times_s, np.asarray(curves.hs), color=HS, label="HS, rightward > 0")
    axes.plot(times_s, np.asarray(curves.vs), color=VS, label="VS, downward > 0")
    axes.axhline(0.0, color="0.7", linewidth=0.8, zorder=0)
    axes.set_ylim(-1.05, 1.05)
    axes.set_ylabel("response")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def _draw_lanes(axes: Any, times_s: Any, ways: Any) -> None:
    """Shade the spans in which a direction was named."""
    if times_s.size < 2:
        return
    step_s = float(np.median(np.diff(times_s)))
    cuts = np.flatnonzero(np.diff(ways) | (np.diff(times_s) > 1.5 * step_s)) + 1
    named: set[Direction] = set()
    for span in np.split(np.arange(ways.size), cuts):
        way = WAYS[ways[span[0]]]
        if way is Direction.NONE:
            continue
        label = None if way in named else way.value
        named.add(way)
        axes.axvspan(
            times_s[span[0]] - step_s,
            times_s[span[-1]],
            color=WAY_COLOUR[way],
            alpha=0.6,
            linewidth=0,
            label=label,
        )


def _draw_rates(axes: Any, curves: Curves) -> None:
    times_s, (on, off) = curves.rates()
    axes.plot(times_s, on * 1e-3, color=ON, label="ON")
    axes.plot(times_s, off * 1e-3, color=OFF, label="OFF")
    axes.set_ylim(bottom=0)
    axes.set_ylabel("kev/s")
    axes.set_xlabel("time [s]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
