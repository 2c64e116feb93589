"""The street's luminance point by point, where a pixel's middle does not tell all."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Eye
from sim.geometry.rectangles import Rectangle
from sim.geometry.rigid_transform import transform_point
from sim.keyframes.background import Background
from sim.keyframes.pixel_labels import with_neighbours
from sim.shadows.lamp_light import beam_lux, share_let_through
from sim.shadows.moving_light import Lights

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]


@compiled
def light_points(
    street: Background,
    lights: Lights,
    eye: Eye,
    rectangle: Rectangle,
    size: int,
    label: I32,
    lit: F32,
    lux: F32,
    marked: Bools,
) -> F32:
    """The street's luminance at the fine points around marked pixels; 0 behind movers [cd/m²]."""
    focal, centre_x, centre_y = eye
    nearness, normals, parts = street.nearness, street.normals, street.points
    albedo, gains = street.albedo_points, lights.gains
    maps, sizes, views, source = lights.maps, lights.sizes, lights.views, lights.light
    parallel, beams, reach_m = lights.parallel, lights.beams, lights.beam_range_m
    x0, y0, _, _ = rectangle
    count, height, width = lit.shape
    points = np.empty(label.shape, np.float32)
    near = with_neighbours(marked)
    even = np.empty(count, np.bool_)
    share = np.empty(count)
    for row in range(height):
        for column in range(width):
            if not near[row, column]:
                continue
            uneven = False
            for light in range(count):
                even[light] = _evenly_lit(lit, row, column, light)
                uneven |= not even[light]
                share[light] = lit[light, row, column]
            in_beam = _near_any(lux, row, column)
            n_x = normals[y0 + row, x0 + column, 0]
            n_y = normals[y0 + row, x0 + column, 1]
            n_z = normals[y0 + row, x0 + column, 2]
            for i in range(row * size, (row + 1) * size):
                for j in range(column * size, (column + 1) * size):
                    points[i, j] = 0.0
                    if label[i, j] >= 0:
                        continue
                    v, u = y0 * size + i, x0 * size + j
                    x = y = z = 0.0
                    if uneven or in_beam:
                        z = 1.0 / nearness[v, u]
                        x = ((u + 0.5) / size - centre_x) / focal * z
                        y = ((v + 0.5) / size - centre_y) / focal * z
                    if uneven:
                        for light in range(count):
                            if not even[light]:
                                share[light] = 1.0
                        for shadow in range(len(source)):
                            if not even[source[shadow]]:
                                at = transform_point(views, shadow, x, y, z)
                                share[source[shadow]] *= share_let_through(
                                    maps, sizes, parallel, shadow, at[0], at[1], at[2]
                                )
                    value = gains[0] * parts[v, u, 0]
                    for light in range(count):
                        value += gains[1 + light] * share[light] * parts[v, u, 1 + light]
                    if in_beam:
                        for k in range(len(beams)):
                            here = beam_lux(beams, k, reach_m, x, y, z, n_x, n_y, n_z)
                            value += here * albedo[v, u]
                    points[i, j] = value
    return points


@compiled
def _near_any(lux: F32, row: int, column: int) -> bool:
    """Whether a pixel or a neighbour is above 0."""
    for i in range(max(row - 1, 0), min(row + 2, lux.shape[0])):
        for j in range(max(column - 1, 0), min(column + 2, lux.shape[1])):
            if lux[i, j] > 0:
                return True
    return False


@compiled
def _evenly_lit(lit: F32, row: int, column: int, light: int) -> bool:
    """Whether a pixel and its neighbours get the same share of a light."""
    for i in range(max(row - 1, 0), min(row + 2, lit.shape[1])):
        for j in range(max(column - 1, 0), min(column + 2, lit.shape[2])):
            if lit[light, i, j] != lit[light, row, column]:
                return False
    return True
