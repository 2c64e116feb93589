"""The part of a film below the image: directions and responses over the whole time."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from scenarios.film.material import Material
from scenarios.film.track import Track
from scenarios.output.figures import literal
from scenarios.styles.method_style import method_style

HEIGHT_PX = 150
_DPI = 100
_ARROWS = {"right": "→", "left": "←", "up": "↑", "down": "↓"}
_HS, _VS, _GREY, _LANE = "black", "0.55", "0.8", "0.88"
_FUTURE = 0.25
"""Contrast of what comes after the moment that is shown."""
_LABELLED_SHARE = 0.1
"""Shortest period of one direction that gets a label, as a share of the film (by eye)."""
_STYLE: Any = {"font.size": 7.5, "axes.spines.top": False, "axes.spines.right": False}


class Curves:
    """Curves of a film, drawn once; the part after the moment that is shown is pale."""

    def __init__(self, material: Material, span_us: tuple[int, int], width_px: int) -> None:
        """Draw the curves.

        Args:
            material: what the film shows.
            span_us: first and last time of the film [µs].
            width_px: width of the image.
        """
        self._span_us = span_us
        with mpl.rc_context(rc=_STYLE):
            size_in = (width_px / _DPI, HEIGHT_PX / _DPI)
            figure = Figure(figsize=size_in, dpi=_DPI, layout="constrained")
            canvas = FigureCanvasAgg(figure)
            lanes, responses = figure.subplots(2, 1, sharex=True, height_ratios=(1, 2.4))
            _draw_lanes(lanes, material, span_us)
            _draw_responses(responses, material, span_us)
            canvas.draw()  # type: ignore[no-untyped-call]
            image = np.asarray(canvas.buffer_rgba())[..., :3].copy()  # type: ignore[no-untyped-call]
            box = responses.get_window_extent()
        self._image: npt.NDArray[np.uint8] = image
        self._pale = (255 - (255 - image.astype(float)) * _FUTURE).astype(np.uint8)
        self._x_px = (box.x0, box.x1)
        self._top_px = image.shape[0] - int(box.y1)
        self._bottom_px = image.shape[0] - int(box.y0)

    def at(self, t_us: int) -> npt.NDArray[np.uint8]:
        """Return the (HEIGHT_PX, width, 3) image of the curves at a time [µs]."""
        start, end = self._span_us
        x0, x1 = self._x_px
        x = round(x0 + (x1 - x0) * (t_us - start) / max(1, end - start))
        right = round(x1) + 1
        image = self._image.copy()
        image[: self._bottom_px, x:right] = self._pale[: self._bottom_px, x:right]
        image[: self._bottom_px, x : x + 1] = 90
        return image


def _draw_lanes(axes: Any, material: Material, span_us: tuple[int, int]) -> None:
    """Draw the directions of the truth and of the method as bars with arrows."""
    lanes: list[tuple[str, Track[str]]] = []
    if material.truth is not None:
        lanes.append(("truth", material.truth.direction))
    if material.estimates.method is not None:
        label = literal(method_style(material.estimates.method).label)
        lanes.append((label, material.estimates.direction))
    for row, (_, track) in enumerate(lanes):
        for start_us, end_us, direction in _periods(track, span_us):
            start_s, end_s = start_us * 1e-6, end_us * 1e-6
            axes.broken_barh([(start_s, end_s - start_s)], (row + 0.06, 0.88), color=_LANE)
            text = f" {_ARROWS.get(direction, '')} {direction}"
            if end_us - start_us > _LABELLED_SHARE * (span_us[1] - span_us[0]):
                axes.text(start_s, row + 0.52, text, va="center")
    axes.set_yticks([row + 0.5 for row in range(len(lanes))], [name for name, _ in lanes])
    axes.set_ylim(max(1, len(lanes)), 0)
    axes.tick_params(length=0, labelbottom=False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _periods(track: Track[str], span_us: tuple[int, int]) -> list[tuple[int, int, str]]:
    """Return start, end and name of each period of one direction in a span."""
    changes = [
        (t_us, value)
        for k, (t_us, value) in enumerate(zip(track.t_us, track.values, strict=True))
        if k == 0 or value != track.values[k - 1]
    ]
    ends = [*changes[1:], (span_us[1], "")]
    clipped = [
        (max(start_us, span_us[0]), min(end_us, span_us[1]), value)
        for (start_us, value), (end_us, _) in zip(changes, ends, strict=True)
    ]
    return [(start, end, value) for start, end, value in clipped if value and end > start]


def _draw_responses(axes: Any, material: Material, span_us: tuple[int, int]) -> None:
    axes.set_xlim(span_us[0] * 1e-6, span_us[1] * 1e-6)
    axes.axhline(0.0, color=_GREY, linewidth=0.8)
    shown = material.estimates
    greatest = 0.0
    for track, name, colour, style in (
        (shown.hs, "HS, rightward > 0", _HS, "-"),
        (shown.vs, "VS, downward > 0", _VS, "--"),
    ):
        if track.t_us:
            times_s = np.asarray(track.t_us) * 1e-6
            axes.plot(times_s, track.values, color=colour, linestyle=style, label=name, lw=1.2)
            greatest = max(greatest, *map(abs, track.values))
    axes.set_ylim(-1.15 * (greatest or 1.0), 1.15 * (greatest or 1.0))
    axes.set_xlabel("time [s]", labelpad=1)
    axes.set_ylabel("response")
    axes.locator_params(axis="y", nbins=3)
    if greatest:
        axes.legend(loc="lower left", frameon=False, ncols=2, borderpad=0.1, handlelength=1.6)
