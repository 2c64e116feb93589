"""Luminance of the background at the sub-pixels of pixels that are not evenly lit."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Projection
from sim.geometry.rectangles import Rectangle
from sim.geometry.rigid_transform import transform_point
from sim.keyframes.background import Background
from sim.keyframes.pixel_labels import dilate
from sim.shadows.point_illumination import beam_lux, unshadowed_share
from sim.shadows.shadows_and_beams import ShadowsAndBeams

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]


@compiled
def shade_subpixels(
    background: Background,
    effects: ShadowsAndBeams,
    projection: Projection,
    rectangle: Rectangle,
    supersample: int,
    label: I32,
    lit: F32,
    lux: F32,
    marked: Bools,
) -> F32:
    """Return the luminance of the background at the sub-pixels in and around marked pixels.

    Args:
        background: the static background.
        effects: shadows and beams at this time.
        projection: projection of the camera.
        rectangle: x0, y0, x1, y1 [px].
        supersample: sub-pixels per pixel and axis.
        label: (rows, columns) label of each of the rectangle's sub-pixels.
        lit: (lights, height, width) share of each light that arrives at the pixel centres.
        lux: (height, width) illuminance from beams at the pixel centres [lux].
        marked: (height, width) bool, the marked pixels.

    Returns:
        (rows, columns) float32 [cd/m²]; 0 behind moving objects, and undefined elsewhere.
    """
    focal, centre_x, centre_y = projection
    nearness, normals, layers = (
        background.subpixel_nearness,
        background.normals,
        background.subpixels,
    )
    albedo, gains = background.subpixel_albedo, effects.gains
    maps, sizes, views, light_of = effects.maps, effects.sizes, effects.views, effects.light
    is_sun, beams, range_m = effects.is_sun, effects.beams, effects.beam_range_m
    x0, y0, _, _ = rectangle
    count, height, width = lit.shape
    luminance = np.empty(label.shape, np.float32)
    near = dilate(marked)
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
            in_beam = _near_beam(lux, row, column)
            n_x = normals[y0 + row, x0 + column, 0]
            n_y = normals[y0 + row, x0 + column, 1]
            n_z = normals[y0 + row, x0 + column, 2]
            for i in range(row * supersample, (row + 1) * supersample):
                for j in range(column * supersample, (column + 1) * supersample):
                    luminance[i, j] = 0.0
                    if label[i, j] >= 0:
                        continue
                    v, u = y0 * supersample + i, x0 * supersample + j
                    x = y = z = 0.0
                    if uneven or in_beam:
                        z = 1.0 / nearness[v, u]
                        x = ((u + 0.5) / supersample - centre_x) / focal * z
                        y = ((v + 0.5) / supersample - centre_y) / focal * z
                    if uneven:
                        for light in range(count):
                            if not even[light]:
                                share[light] = 1.0
                        for shadow in range(len(light_of)):
                            if not even[light_of[shadow]]:
                                at = transform_point(views, shadow, x, y, z)
                                share[light_of[shadow]] *= unshadowed_share(
                                    maps, sizes, is_sun, shadow, at[0], at[1], at[2]
                                )
                    value = gains[0] * layers[v, u, 0]
                    for light in range(count):
                        value += gains[1 + light] * share[light] * layers[v, u, 1 + light]
                    if in_beam:
                        for k in range(len(beams)):
                            here = beam_lux(beams, k, range_m, x, y, z, n_x, n_y, n_z)
                            value += here * albedo[v, u]
                    luminance[i, j] = value
    return luminance


@compiled
def _near_beam(lux: F32, row: int, column: int) -> bool:
    """Return True if a beam lights a pixel or one of its neighbours."""
    for i in range(max(row - 1, 0), min(row + 2, lux.shape[0])):
        for j in range(max(column - 1, 0), min(column + 2, lux.shape[1])):
            if lux[i, j] > 0:
                return True
    return False


@compiled
def _evenly_lit(lit: F32, row: int, column: int, light: int) -> bool:
    """Return True if a pixel and its neighbours get equal shares of a light."""
    for i in range(max(row - 1, 0), min(row + 2, lit.shape[1])):
        for j in range(max(column - 1, 0), min(column + 2, lit.shape[2])):
            if lit[light, i, j] != lit[light, row, column]:
                return False
    return True
