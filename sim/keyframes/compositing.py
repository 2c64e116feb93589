"""Composite one sample's image: the background with shadows and beams, and moving parts over it.

A pixel that shows only one thing takes its luminance at once. A pixel at an edge is the weighted
mean of its sub-pixels; see `sim.keyframes.pixel_labels`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Projection
from sim.geometry.rectangles import Rectangle
from sim.keyframes.background import Background
from sim.keyframes.pixel_centre_shading import shade_pixel_centres
from sim.keyframes.pixel_labels import mark_edges, pixel_labels
from sim.keyframes.subpixel_shading import shade_subpixels
from sim.keyframes.surface_lookup import Surfaces, surface_luminance
from sim.shadows.shadows_and_beams import ShadowsAndBeams

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]


@compiled
def composite(
    image: F32,
    background: Background,
    effects: ShadowsAndBeams,
    surfaces: Surfaces,
    projection: Projection,
    label: I32,
    nearness: F32,
    weights: F32,
    rectangle: Rectangle,
) -> None:
    """Composite a rectangle of the image, in place.

    Args:
        image: (height, width) float32 [cd/m²].
        background: the static background.
        effects: shadows and beams at this time.
        surfaces: surfaces of the moving parts.
        projection: projection of the camera.
        label: (rows, columns) int32, moving part at each sub-pixel of the rectangle; -1 for the
            background.
        nearness: (rows, columns) float32 nearness of the moving part at each sub-pixel [1/m].
        weights: (3 S,) weights of the pixel's aperture along an axis.
        rectangle: x0, y0, x1, y1 [px].
    """
    supersample = len(weights) // 3
    pixel_label = pixel_labels(label, supersample)
    lit, lux = shade_pixel_centres(background, effects, projection, rectangle, pixel_label)
    marked = mark_edges(pixel_label, lux)
    subpixels = shade_subpixels(
        background, effects, projection, rectangle, supersample, label, lit, lux, marked
    )
    _fill_uniform_pixels(
        image,
        background,
        effects.gains,
        surfaces,
        projection,
        rectangle,
        supersample,
        pixel_label,
        lit,
        nearness,
        marked,
    )
    _blend_edge_pixels(
        image, surfaces, projection, rectangle, weights, label, nearness, subpixels, marked
    )


@compiled
def _fill_uniform_pixels(
    image: F32,
    background: Background,
    gains: F64,
    surfaces: Surfaces,
    projection: Projection,
    rectangle: Rectangle,
    supersample: int,
    pixel_label: I32,
    lit: F32,
    nearness: F32,
    marked: Bools,
) -> None:
    """Fill the pixels that are not marked: each shows only one thing."""
    layers = background.pixels
    x0, y0, _, _ = rectangle
    centre = supersample // 2
    off = (centre + 0.5) / supersample - 0.5
    for row in range(pixel_label.shape[0]):
        for column in range(pixel_label.shape[1]):
            if marked[row, column]:
                continue
            v, u, part = y0 + row, x0 + column, pixel_label[row, column]
            if part < 0:
                value = gains[0] * layers[0, v, u]
                for k in range(len(lit)):
                    value += gains[1 + k] * lit[k, row, column] * layers[1 + k, v, u]
            else:
                depth = 1.0 / nearness[row * supersample + centre, column * supersample + centre]
                value = surface_luminance(
                    surfaces, projection, part, u + 0.5 + off, v + 0.5 + off, depth, off, off
                )
            image[v, u] = value


@compiled
def _blend_edge_pixels(
    image: F32,
    surfaces: Surfaces,
    projection: Projection,
    rectangle: Rectangle,
    weights: F32,
    label: I32,
    nearness: F32,
    subpixels: F32,
    marked: Bools,
) -> None:
    """Blend the marked pixels from their sub-pixels, weighted with the aperture.

    The luminance of a part is looked up once for a pixel, at the part's sub-pixel nearest to the
    pixel centre.
    """
    x0, y0, _, _ = rectangle
    size = len(weights) // 3
    count = len(surfaces.means)
    coverage, nearest = np.zeros(count), np.full(count, np.inf)
    position = np.empty((count, 2), np.int64)
    parts = np.empty(count, np.int64)
    for row in range(marked.shape[0]):
        for column in range(marked.shape[1]):
            if not marked[row, column]:
                continue
            value = total = 0.0
            found = 0
            for i in range(max((row - 1) * size, 0), min((row + 2) * size, label.shape[0])):
                down = i + 0.5 - (row + 0.5) * size
                for j in range(
                    max((column - 1) * size, 0), min((column + 2) * size, label.shape[1])
                ):
                    weight = weights[i - (row - 1) * size] * weights[j - (column - 1) * size]
                    total += weight
                    part = label[i, j]
                    if part < 0:
                        value += weight * subpixels[i, j]
                        continue
                    if coverage[part] == 0.0:
                        parts[found] = part
                        found += 1
                    coverage[part] += weight
                    right = j + 0.5 - (column + 0.5) * size
                    off = right * right + down * down
                    if off < nearest[part]:
                        nearest[part] = off
                        position[part, 0], position[part, 1] = i, j
            for k in range(found):
                part = parts[k]
                i, j = position[part]
                u, v = x0 + (j + 0.5) / size, y0 + (i + 0.5) / size
                off_u, off_v = u - (x0 + column + 0.5), v - (y0 + row + 0.5)
                luminance = surface_luminance(
                    surfaces, projection, part, u, v, 1.0 / nearness[i, j], off_u, off_v
                )
                value += coverage[part] * luminance
                coverage[part], nearest[part] = 0.0, np.inf
            image[y0 + row, x0 + column] = value / total
