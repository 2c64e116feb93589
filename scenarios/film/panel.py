"""One panel of a film: title, image with events, legend and curves."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from flybench.printable import printable
from scenarios.film.curves import HEIGHT_PX, Curves
from scenarios.film.material import Box, Material
from scenarios.film.playback import Moment
from scenarios.output.colours import OFF, ON, Rgb

BLACK, WHITE = (0, 0, 0), (255, 255, 255)
_HEAD_PX, _LEGEND_PX = 22, 20
_TEXT_PX = 13
_FRAME_SHARE = 0.35
"""Contrast of the APS frame behind the events, so that both colours stay clear (by eye)."""
_BRIGHT_SHARE = 99.0
"""Percentile of the grey levels of a frame that is shown white."""
_DASH_PX = 7


class Panel:
    """Draws what a film shows of one recording."""

    def __init__(
        self, material: Material, *, span_us: tuple[int, int], scale: int, note: str
    ) -> None:
        """Draw what does not change.

        Args:
            material: what the film shows.
            span_us: first and last time of the film [µs].
            scale: pixels of the film per pixel of the sensor, along each axis.
            note: text after the time, such as the speed.
        """
        self._material, self._scale, self._note = material, scale, note
        self._size = material.width * scale, material.height * scale
        self._curves = Curves(material, span_us, self._size[0])

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of the images: rows, columns and 3 colours."""
        width, height = self._size
        return _HEAD_PX + height + _LEGEND_PX + HEIGHT_PX, width, 3

    def draw(self, moment: Moment) -> npt.NDArray[np.uint8]:
        """Return the panel at a moment, as (rows, columns, 3)."""
        rows, columns, _ = self.shape
        canvas = Image.new("RGB", (columns, rows), WHITE)
        canvas.paste(Image.fromarray(self._sensor_image(moment)), (0, _HEAD_PX))
        canvas.paste(Image.fromarray(self._curves.at(moment.t_us)), (0, rows - HEIGHT_PX))
        pen = ImageDraw.Draw(canvas)
        self._draw_boxes(pen, moment.t_us)
        self._draw_head(pen, moment.t_us)
        self._draw_legend(pen)
        return np.asarray(canvas)

    def _sensor_image(self, moment: Moment) -> npt.NDArray[np.uint8]:
        """Return events over the frame, magnified."""
        shape = self._material.height, self._material.width
        image = np.full((*shape, 3), 255, np.uint8)
        if moment.frame is not None and moment.frame.shape == shape:
            image[:] = _pale(moment.frame)[..., None]
        events = moment.events
        image[events["y"], events["x"]] = np.where(events["p"][:, None], ON, OFF)
        return image.repeat(self._scale, axis=0).repeat(self._scale, axis=1)

    def _draw_boxes(self, pen: Any, t_us: int) -> None:
        truth, region = self._material.truth, self._material.estimates.region.at(t_us)
        box = truth.box.at(t_us) if truth is not None else None
        if box is not None:
            _outline(pen, self._in_panel(box), dash_px=_DASH_PX)
        if region is not None:
            _outline(pen, self._in_panel(region))
            direction = self._material.estimates.direction.at(t_us)
            if direction:
                _arrow(pen, self._in_panel(region), direction)

    def _in_panel(self, box: Box) -> Box:
        x0, y0, x1, y1 = (side * self._scale for side in box)
        return x0, y0 + _HEAD_PX, x1 - 1, y1 - 1 + _HEAD_PX

    def _draw_head(self, pen: Any, t_us: int) -> None:
        columns = self.shape[1]
        time = f"{t_us * 1e-6:.3f} s, {self._note}"
        pen.text((columns - 4, 4), time, fill=BLACK, font=_font(), anchor="ra")
        room = columns - 16 - _font().getlength(time)
        pen.text((4, 4), _fitting(printable(self._material.name), room), fill=BLACK, font=_font())

    def _draw_legend(self, pen: Any) -> None:
        y = _HEAD_PX + self._size[1] + 3
        x = 4.0
        for colour, name in ((ON, "ON"), (OFF, "OFF")):
            x = _legend_entry(pen, x, y, name, fill=colour)
        if any(self._material.estimates.region.values):
            x = _legend_entry(pen, x, y, "attended region")
        if self._material.truth is not None:
            _legend_entry(pen, x, y, "truth", dash_px=3)


def _pale(frame: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """Return a frame from light grey to white."""
    white = max(1.0, float(np.percentile(frame, _BRIGHT_SHARE)))
    return (255 * (1 - _FRAME_SHARE * (1 - np.minimum(frame / white, 1.0)))).astype(np.uint8)


def _outline(pen: Any, box: Box, *, dash_px: int = 0, width: int = 2) -> None:
    """Draw a black outline with a white seam, so that it is visible on every background."""
    x0, y0, x1, y1 = box
    corners = ((x0, y0, x1, y0), (x0, y1, x1, y1), (x0, y0, x0, y1), (x1, y0, x1, y1))
    for ax, ay, bx, by in corners:
        pen.line((ax, ay, bx, by), fill=WHITE, width=width + 2)
        length = max(bx - ax, by - ay)
        step = dash_px or max(length, 1)
        for start in range(0, length, 2 * step if dash_px else step):
            end = min(start + step, length)
            dx, dy = (1, 0) if by == ay else (0, 1)
            ends = (ax + start * dx, ay + start * dy, ax + end * dx, ay + end * dy)
            pen.line(ends, fill=BLACK, width=width)


_STEPS = {"right": (1, 0), "left": (-1, 0), "up": (0, -1), "down": (0, 1)}


def _arrow(pen: Any, box: Box, direction: str) -> None:
    """Draw an arrow in the middle of a box."""
    x, y = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
    half = max(12.0, 0.3 * min(box[2] - box[0], box[3] - box[1]))
    dx, dy = _STEPS[direction]
    tip, tail = (x + half * dx, y + half * dy), (x - half * dx, y - half * dy)
    for colour, width in ((WHITE, 7), (BLACK, 3)):
        pen.line((*tail, *tip), fill=colour, width=width)
        for side in (-1, 1):
            barb = (tip[0] - 9 * dx + side * 7 * dy, tip[1] - 9 * dy + side * 7 * dx)
            pen.line((*barb, *tip), fill=colour, width=width)


def _legend_entry(
    pen: Any, x: float, y: int, name: str, *, fill: Rgb | None = None, dash_px: int = 0
) -> float:
    """Draw one entry of the legend, and return where the next one begins."""
    box = (int(x), y + 2, int(x) + 16, y + 13)
    if fill is None:
        _outline(pen, box, dash_px=dash_px, width=1)
    else:
        pen.rectangle(box, fill=fill)
    pen.text((x + 21, y), name, fill=BLACK, font=_font())
    return x + 35 + float(_font().getlength(name))


def _fitting(text: str, room_px: float) -> str:
    """Return a text, shortened if it is wider than the room for it."""
    if _font().getlength(text) <= room_px:
        return text
    while text and _font().getlength(f"{text}…") > room_px:
        text = text[:-1]
    return f"{text}…"


@cache
def _font() -> ImageFont.FreeTypeFont:
    """Return Matplotlib's font, which is installed with it."""
    path = Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    return ImageFont.truetype(path, _TEXT_PX)
