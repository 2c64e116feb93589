"""One sample's image: the still street under its lights, and over it what moves.

Pixels that show one thing are drawn whole, those at edges point by point; see
`sim.keyframes.pixel_labels`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Eye
from sim.geometry.rectangles import Rectangle
from sim.keyframes.background import Background
from sim.keyframes.pixel_centre_shading import light_middles
from sim.keyframes.pixel_labels import mark_edges, pixel_codes
from sim.keyframes.subpixel_shading import light_points
from sim.keyframes.surface_lookup import Surfaces, surface_light
from sim.shadows.moving_light import Lights

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]


@compiled
def compose(
    image: F32,
    street: Background,
    lights: Lights,
    surfaces: Surfaces,
    eye: Eye,
    label: I32,
    nearness: F32,
    weights: F32,
    rectangle: Rectangle,
) -> None:
    """Draw a rectangle of the image, in place.

    Args:
        image: (height, width) float32 [cd/m²].
        street: what never moves.
        lights: at this time.
        surfaces: of the movers.
        eye: the camera's.
        label: fine points of the rectangle, int32: which body is seen, -1 for the street.
        nearness: fine points of the rectangle, float32 [1/m], where a body is seen.
        weights: (3 S,) the pixel's aperture along an axis.
        rectangle: x0, y0, x1, y1 [px].
    """
    size = len(weights) // 3
    code = pixel_codes(label, size)
    lit, lux = light_middles(street, lights, eye, rectangle, code)
    marked = mark_edges(code, lux)
    points = light_points(street, lights, eye, rectangle, size, label, lit, lux, marked)
    _draw_plain(
        image, street, lights.gains, surfaces, eye, rectangle, size, code, lit, nearness, marked
    )
    _draw_edges(image, surfaces, eye, rectangle, weights, label, nearness, points, marked)


@compiled
def _draw_plain(
    image: F32,
    street: Background,
    gains: F64,
    surfaces: Surfaces,
    eye: Eye,
    rectangle: Rectangle,
    size: int,
    code: I32,
    lit: F32,
    nearness: F32,
    marked: Bools,
) -> None:
    """Draw the pixels that show one thing."""
    light, cover, pieces, moves, shares, means, per_pixel = surfaces
    focal, centre_x, centre_y = eye
    parts = street.pixels
    x0, y0, _, _ = rectangle
    middle = size // 2
    off = (middle + 0.5) / size - 0.5
    for row in range(code.shape[0]):
        for column in range(code.shape[1]):
            if marked[row, column]:
                continue
            v, u, body = y0 + row, x0 + column, code[row, column]
            if body < 0:
                value = gains[0] * parts[0, v, u]
                for k in range(len(lit)):
                    value += gains[1 + k] * lit[k, row, column] * parts[1 + k, v, u]
            else:
                depth = 1.0 / nearness[row * size + middle, column * size + middle]
                value = surface_light(
                    light,
                    cover,
                    pieces,
                    moves,
                    shares,
                    means,
                    per_pixel,
                    focal,
                    centre_x,
                    centre_y,
                    body,
                    u + 0.5 + off,
                    v + 0.5 + off,
                    depth,
                    off,
                    off,
                )
            image[v, u] = value


@compiled
def _draw_edges(
    image: F32,
    surfaces: Surfaces,
    eye: Eye,
    rectangle: Rectangle,
    weights: F32,
    label: I32,
    nearness: F32,
    points: F32,
    marked: Bools,
) -> None:
    """Draw the pixels that show several things, each point with its weight in the aperture."""
    light, cover, pieces, moves, shares, means, per_pixel = surfaces
    focal, centre_x, centre_y = eye
    x0, y0, _, _ = rectangle
    size = len(weights) // 3
    covers, nearest = np.zeros(len(means)), np.full(len(means), np.inf)
    place = np.empty((len(means), 2), np.int64)
    bodies = np.empty(len(means), np.int64)
    for row in range(marked.shape[0]):
        for column in range(marked.shape[1]):
            if not marked[row, column]:
                continue
            value = whole = 0.0
            found = 0
            for i in range(max((row - 1) * size, 0), min((row + 2) * size, label.shape[0])):
                down = i + 0.5 - (row + 0.5) * size
                for j in range(
                    max((column - 1) * size, 0), min((column + 2) * size, label.shape[1])
                ):
                    weight = weights[i - (row - 1) * size] * weights[j - (column - 1) * size]
                    whole += weight
                    body = label[i, j]
                    if body < 0:
                        value += weight * points[i, j]
                        continue
                    if covers[body] == 0.0:
                        bodies[found] = body
                        found += 1
                    covers[body] += weight
                    right = j + 0.5 - (column + 0.5) * size
                    off = right * right + down * down
                    if off < nearest[body]:
                        nearest[body] = off
                        place[body, 0], place[body, 1] = i, j
            for k in range(found):
                body = bodies[k]
                i, j = place[body]
                u, v = x0 + (j + 0.5) / size, y0 + (i + 0.5) / size
                seen = surface_light(
                    light,
                    cover,
                    pieces,
                    moves,
                    shares,
                    means,
                    per_pixel,
                    focal,
                    centre_x,
                    centre_y,
                    body,
                    u,
                    v,
                    1.0 / nearness[i, j],
                    u - (x0 + column + 0.5),
                    v - (y0 + row + 0.5),
                )
                value += covers[body] * seen
                covers[body], nearest[body] = 0.0, np.inf
            image[y0 + row, x0 + column] = value / whole
