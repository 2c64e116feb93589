"""Composite one sample's image: the background with shadows and beams, and moving parts over it.

A pixel that shows only one thing takes its luminance at once. A pixel at an edge is the weighted
mean of its sub-pixels; see `sim.compositing.pixel_labels`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.compositing.background import Background
from sim.compositing.background_light import light_pixel_centres, light_subpixels
from sim.compositing.canvas import Canvas
from sim.compositing.edge_pixels import Aperture, blend_edge_pixels
from sim.compositing.pixel_labels import dilate, mark_edges
from sim.compositing.surface_lookup import Surfaces, surface_run
from sim.geometry.pinhole import Projection
from sim.geometry.rectangles import Rectangle
from sim.shadows.shadows_and_beams import ShadowsAndBeams

F64 = npt.NDArray[np.float64]


@compiled
def composite(
    canvas: Canvas,
    background: Background,
    effects: ShadowsAndBeams,
    surfaces: Surfaces,
    projection: Projection,
    seen: Aperture,
    rectangle: Rectangle,
) -> None:
    """Composite a rectangle of the image.

    Args:
        canvas: the canvas, with the moving parts in `label`, `nearness` and `pixel_label`, and the
            background as without moving objects in `image`. Everything else is overwritten.
        background: the static background.
        effects: shadows and beams at this time.
        surfaces: surfaces of the moving parts.
        projection: projection of the camera.
        seen: aperture of a pixel.
        rectangle: x0, y0, x1, y1 [px].
    """
    supersample = len(seen.weights) // 3
    light_pixel_centres(canvas, background, effects, projection, rectangle)
    mark_edges(canvas.pixel_label, canvas.in_beam, rectangle, canvas.marked, canvas.scratch)
    dilate(canvas.marked, rectangle, canvas.scratch)
    light_subpixels(canvas, background, effects, projection, rectangle, supersample)
    _fill_uniform_pixels(canvas, background, effects.gains, surfaces, rectangle, supersample)
    blend_edge_pixels(canvas, surfaces, seen, rectangle)


@compiled
def _fill_uniform_pixels(
    canvas: Canvas,
    background: Background,
    gains: F64,
    surfaces: Surfaces,
    rectangle: Rectangle,
    supersample: int,
) -> None:
    """Fill the pixels that are not marked: each shows only one thing.

    The background in full light is in the image already. Pixels of a row that show the same part
    are looked up together.
    """
    layers, pixel_label, marked = background.pixels, canvas.pixel_label, canvas.marked
    x0, y0, x1, y1 = rectangle
    scratch = np.empty((4, x1))
    for row in range(y0, y1):
        i, column = np.uintp(row), x0
        while column < x1:
            j, end = np.uintp(column), column + 1
            part = pixel_label[i, j]
            if not marked[i, j] and part >= 0:
                while end < x1 and pixel_label[i, np.uintp(end)] == part:
                    if marked[i, np.uintp(end)]:
                        break
                    end += 1
                centres = canvas.nearness[row * supersample + supersample // 2]
                surface_run(surfaces, part, row, column, end, centres, scratch, canvas.image[row])
            elif not marked[i, j] and part < -1:
                value = gains[0] * layers[0, i, j]
                for k in range(len(canvas.lit)):
                    value += gains[1 + k] * canvas.lit[k, i, j] * layers[1 + k, i, j]
                canvas.image[i, j] = value
            column = end
