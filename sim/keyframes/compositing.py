"""Composite one sample's image: the background with shadows and beams, and moving parts over it.

A pixel that shows only one thing takes its luminance at once. A pixel at an edge is the weighted
mean of its sub-pixels; see `sim.keyframes.pixel_labels`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined
from sim.geometry.pinhole import Projection
from sim.geometry.rectangles import Rectangle
from sim.keyframes.background import Background
from sim.keyframes.background_light import light_pixel_centres, light_subpixels
from sim.keyframes.canvas import Canvas
from sim.keyframes.pixel_labels import dilate, label_pixels, mark_edges
from sim.keyframes.surface_lookup import Surfaces, surface_luminance, surface_run
from sim.raster.aperture import aperture_weights
from sim.shadows.shadows_and_beams import ShadowsAndBeams

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]


class Aperture(NamedTuple):
    """Sub-pixels in the aperture of a pixel: S × S of its own, and as many of each neighbour.

    Attributes:
        weights: (3 S,) float64 weights along an axis, with a sum of 1.
        order: (9 S², 2) int64 rows and columns of the sub-pixels, the nearest to the pixel's centre
            first.
    """

    weights: F64
    order: I64


def aperture(supersample: int, blur_px: float) -> Aperture:
    """Return the aperture of a pixel.

    Args:
        supersample: sub-pixels per pixel and axis, S.
        blur_px: standard deviation of the lens's point spread [px].
    """
    count = 3 * supersample
    rows, columns = np.divmod(np.arange(count * count), count)
    off = (2 * rows + 1 - count) ** 2 + (2 * columns + 1 - count) ** 2
    nearest = np.argsort(off, kind="stable")
    order = np.stack([rows[nearest], columns[nearest]], axis=1)
    weights = aperture_weights(supersample, blur_px).astype(np.float64)
    return Aperture(weights / weights.sum(), order)


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
        canvas: the canvas, with the moving parts in `label` and `nearness`, and the background as
            without moving objects in `image`. Everything else is overwritten.
        background: the static background.
        effects: shadows and beams at this time.
        surfaces: surfaces of the moving parts.
        projection: projection of the camera.
        seen: aperture of a pixel.
        rectangle: x0, y0, x1, y1 [px].
    """
    supersample = len(seen.weights) // 3
    label_pixels(canvas.label, supersample, rectangle, canvas.pixel_label)
    light_pixel_centres(canvas, background, effects, projection, rectangle)
    mark_edges(canvas.pixel_label, canvas.in_beam, rectangle, canvas.marked, canvas.scratch)
    dilate(canvas.marked, rectangle, canvas.scratch)
    light_subpixels(canvas, background, effects, projection, rectangle, supersample)
    _fill_uniform_pixels(canvas, background, effects.gains, surfaces, rectangle, supersample)
    _blend_edge_pixels(canvas, surfaces, seen, rectangle)


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
    sums = np.empty((2, x1))
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
                surface_run(surfaces, part, row, column, end, centres, sums, canvas.image[row])
            elif not marked[i, j] and part < -1:
                value = gains[0] * layers[0, i, j]
                for k in range(len(canvas.lit)):
                    value += gains[1 + k] * canvas.lit[k, i, j] * layers[1 + k, i, j]
                canvas.image[i, j] = value
            column = end


@compiled
def _blend_edge_pixels(
    canvas: Canvas, surfaces: Surfaces, seen: Aperture, rectangle: Rectangle
) -> None:
    """Blend the marked pixels from their sub-pixels, weighted with the aperture.

    The luminance of a part is looked up once for a pixel, at the part's sub-pixel nearest to the
    pixel centre.
    """
    x0, y0, x1, y1 = rectangle
    label, background, weights = canvas.label, canvas.background, seen.weights
    size = len(weights) // 3
    parts, coverage = np.empty(9 * size * size, np.int64), np.empty(9 * size * size)
    for row in range(y0, y1):
        top, bottom = max((row - 1) * size, y0 * size), min((row + 2) * size, y1 * size)
        for column in range(x0, x1):
            if not canvas.marked[np.uintp(row), np.uintp(column)]:
                continue
            first = (column - 1) * size
            left, right = max(first, x0 * size), min((column + 2) * size, x1 * size)
            value, found = 0.0, 0
            for i in range(top, bottom):
                across, last, share = 0.0, -1, 0.0
                for j in range(left, right):
                    weight = weights[np.uintp(j - first)]
                    part = label[np.uintp(i), np.uintp(j)]
                    if part < 0:
                        across += weight * background[np.uintp(i), np.uintp(j)]
                        continue
                    if part != last:
                        down = weights[np.uintp(i - (row - 1) * size)]
                        found = _add_coverage(parts, coverage, found, last, down * share)
                        last, share = part, 0.0
                    share += weight
                down = weights[np.uintp(i - (row - 1) * size)]
                found = _add_coverage(parts, coverage, found, last, down * share)
                value += down * across
            for k in range(found):
                value += coverage[k] * _part_luminance(
                    canvas, surfaces, seen, parts[k], row, column, rectangle
                )
            if bottom - top < 3 * size or right - left < 3 * size:
                shift = (row - 1) * size
                value /= weights[top - shift : bottom - shift].sum()
                value /= weights[left - first : right - first].sum()
            canvas.image[np.uintp(row), np.uintp(column)] = value


@inlined
def _add_coverage(parts: I64, coverage: F64, found: int, part: int, share: float) -> int:
    """Add to the coverage of a part, and return how many parts have been found."""
    if part < 0:
        return found
    for k in range(found):
        if parts[k] == part:
            coverage[k] += share
            return found
    parts[found], coverage[found] = part, share
    return found + 1


@inlined
def _part_luminance(
    canvas: Canvas,
    surfaces: Surfaces,
    seen: Aperture,
    part: int,
    row: int,
    column: int,
    rectangle: Rectangle,
) -> float:
    """Return the luminance of a part at its sub-pixel nearest to a pixel's centre."""
    x0, y0, x1, y1 = rectangle
    size = len(seen.weights) // 3
    for k in range(len(seen.order)):
        i, j = (row - 1) * size + seen.order[k, 0], (column - 1) * size + seen.order[k, 1]
        inside = y0 * size <= i < y1 * size and x0 * size <= j < x1 * size
        if inside and canvas.label[np.uintp(i), np.uintp(j)] == part:
            nearness = canvas.nearness[np.uintp(i), np.uintp(j)]
            right, down = j + 0.5 - (column + 0.5) * size, i + 0.5 - (row + 0.5) * size
            return surface_luminance(
                surfaces, part, (j + 0.5) / size, (i + 0.5) / size, nearness, right, down
            )
    return 0.0
