"""Everything that is written while a sample is drawn, reserved once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.compositing.background import Background
from sim.geometry.rectangles import Rectangle
from sim.raster.scan_conversion import NO_LABEL

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]


class Canvas(NamedTuple):
    """Buffers of one sample, of the whole image. Only some rectangles of a sample are drawn.

    Attributes:
        image: (height, width) float32 luminance [cd/m²].
        label: (rows, columns) int32 moving part that each sub-pixel shows, or `NO_LABEL`.
        nearness: (rows, columns) float32 1/depth of what each sub-pixel shows [1/m].
        pixel_label: (height, width) int32 what each pixel shows; see
            `sim.compositing.pixel_labels`.
        lit: (layers - 1, height, width) float32 share of each layer but the first that reaches the
            background.
        shadowed: (height, width) int32, a bit for each shadow that falls on the pixel's centre.
        in_beam: (height, width) bool, True where a beam lights the background.
        marked: (height, width) bool, pixels that are drawn from their sub-pixels.
        scratch: (height, width) bool.
        background: (rows, columns) float32 luminance of the background's sub-pixels near marked
            pixels [cd/m²].
        untouched: (height, width) bool, pixels in which `background` is that in full light.
    """

    image: F32
    label: I32
    nearness: F32
    pixel_label: I32
    lit: F32
    shadowed: I32
    in_beam: Bools
    marked: Bools
    scratch: Bools
    background: F32
    untouched: Bools


def blank_canvas(background: Background) -> Canvas:
    """Return the canvas of a background without moving objects."""
    size = background.nearness.shape
    return Canvas(
        image=np.zeros(size, np.float32),
        label=np.full(background.subpixel_nearness.shape, NO_LABEL, np.int32),
        nearness=background.subpixel_nearness.copy(),
        pixel_label=np.full(size, NO_LABEL, np.int32),
        lit=np.ones((len(background.pixels) - 1, *size), np.float32),
        shadowed=np.zeros(size, np.int32),
        in_beam=np.zeros(size, np.bool_),
        marked=np.zeros(size, np.bool_),
        scratch=np.zeros(size, np.bool_),
        background=background.subpixels.sum(axis=0),
        untouched=np.ones(size, np.bool_),
    )


def wipe(canvas: Canvas, background: Background, rectangle: Rectangle, supersample: int) -> None:
    """Remove the moving parts from a rectangle of the canvas.

    Args:
        canvas: the canvas; its labels and nearness are changed.
        background: the static background.
        rectangle: x0, y0, x1, y1 [px].
        supersample: sub-pixels per pixel and axis.
    """
    x0, y0, x1, y1 = (supersample * edge for edge in rectangle)
    canvas.label[y0:y1, x0:x1] = NO_LABEL
    canvas.nearness[y0:y1, x0:x1] = background.subpixel_nearness[y0:y1, x0:x1]


@compiled
def show_bodies(
    label: I32, body_of_part: I32, supersample: int, rectangle: Rectangle, body: I32
) -> None:
    """Write the bodies of the moving parts over a map of what the pixel centres show.

    Args:
        label: (rows, columns) part that each sub-pixel shows; `NO_LABEL` keeps the map's body.
        body_of_part: (parts,) body that each part moves with.
        supersample: sub-pixels per pixel and axis. If it is even, no sub-pixel lies on the pixel
            centre; the one after the centre is taken.
        rectangle: x0, y0, x1, y1 [px].
        body: (height, width) int32, the map.
    """
    x0, y0, x1, y1 = rectangle
    centre = supersample // 2
    for row in range(y0, y1):
        for column in range(x0, x1):
            part = label[row * supersample + centre, column * supersample + centre]
            if part >= 0:
                body[row, column] = body_of_part[part]
