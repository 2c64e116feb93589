"""Light on the background: shadows and beams at pixel centres, and at sub-pixels near edges."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined
from sim.geometry.pinhole import Projection
from sim.geometry.rectangles import Rectangle
from sim.geometry.rigid_transform import transform_point
from sim.keyframes.background import Background
from sim.keyframes.canvas import Canvas
from sim.keyframes.pixel_labels import EDGE
from sim.shadows.point_illumination import beam_lux, unshadowed_share
from sim.shadows.shadows_and_beams import ShadowsAndBeams

F32 = npt.NDArray[np.float32]
I64 = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


@compiled
def light_pixel_centres(
    canvas: Canvas,
    background: Background,
    effects: ShadowsAndBeams,
    projection: Projection,
    rectangle: Rectangle,
) -> None:
    """Find the light that reaches the background at the pixel centres of a rectangle.

    Args:
        canvas: `lit` and `in_beam` are set; shadows are added to `pixel_label`, see `_add_shadow`.
        background: the static background.
        effects: shadows and beams at this time.
        projection: projection of the camera.
        rectangle: x0, y0, x1, y1 [px].
    """
    x0, y0, x1, y1 = rectangle
    canvas.lit[:, y0:y1, x0:x1] = 1.0
    canvas.in_beam[y0:y1, x0:x1] = False
    for shadow in range(len(effects.light)):
        _add_shadow(canvas, background.depth, effects, shadow, projection, rectangle)
    for beam in range(len(effects.beams)):
        _add_beam(canvas, background, effects, beam, projection, rectangle)


@compiled
def _add_shadow(
    canvas: Canvas,
    depth: F32,
    effects: ShadowsAndBeams,
    shadow: int,
    projection: Projection,
    rectangle: Rectangle,
) -> None:
    """Apply one shadow to the background at the pixel centres of a rectangle.

    The shadow multiplies `canvas.lit`. In `canvas.pixel_label`, a negative label is background,
    where each shadow has a bit of −1 − label, which is set where it is complete. A partial shadow
    gives `EDGE`.
    """
    focal, centre_x, centre_y = projection
    maps, sizes, is_sun, view = effects.maps, effects.sizes, effects.is_sun, effects.views[shadow]
    u_right, v_right, w_right = view[0, 0] / focal, view[1, 0] / focal, view[2, 0] / focal
    area, pixel_label = effects.shadow_areas[shadow], canvas.pixel_label
    lit = canvas.lit[effects.light[shadow]]
    for row in range(max(area[1], rectangle[1]), min(area[3], rectangle[3])):
        below = (row + 0.5 - centre_y) / focal
        u_row = view[0, 1] * below + view[0, 2]
        v_row = view[1, 1] * below + view[1, 2]
        w_row = view[2, 1] * below + view[2, 2]
        for column in range(max(area[0], rectangle[0]), min(area[2], rectangle[2])):
            i, j = np.uintp(row), np.uintp(column)
            label = pixel_label[i, j]
            if label >= 0:
                continue
            z, right = depth[i, j], column + 0.5 - centre_x
            u = z * (u_right * right + u_row) + view[0, 3]
            v = z * (v_right * right + v_row) + view[1, 3]
            w = z * (w_right * right + w_row) + view[2, 3]
            share = unshadowed_share(maps, sizes, is_sun, shadow, u, v, w)
            if share >= 1.0:
                continue
            lit[i, j] *= share
            if label != EDGE:
                pixel_label[i, j] = EDGE if share > 0.0 else label - (1 << shadow)


@compiled
def _add_beam(
    canvas: Canvas,
    background: Background,
    effects: ShadowsAndBeams,
    beam: int,
    projection: Projection,
    rectangle: Rectangle,
) -> None:
    """Set `canvas.in_beam` where a beam lights the background at the pixel centre."""
    focal, centre_x, centre_y = projection
    beams, range_m, area = effects.beams, effects.beam_range_m, effects.beam_areas[beam]
    depth, normals = background.depth, background.normals
    for row in range(max(area[1], rectangle[1]), min(area[3], rectangle[3])):
        for column in range(max(area[0], rectangle[0]), min(area[2], rectangle[2])):
            i, j = np.uintp(row), np.uintp(column)
            if canvas.pixel_label[i, j] >= 0 or canvas.in_beam[i, j]:
                continue
            z = depth[i, j]
            x, y = (column + 0.5 - centre_x) / focal * z, (row + 0.5 - centre_y) / focal * z
            n_x, n_y, n_z = normals[i, j, 0], normals[i, j, 1], normals[i, j, 2]
            canvas.in_beam[i, j] = beam_lux(beams, beam, range_m, x, y, z, n_x, n_y, n_z) > 0.0


@compiled
def light_subpixels(
    canvas: Canvas,
    background: Background,
    effects: ShadowsAndBeams,
    projection: Projection,
    rectangle: Rectangle,
    supersample: int,
) -> None:
    """Set the luminance of the background at the sub-pixels of marked pixels and their neighbours.

    Args:
        canvas: `scratch` marks the pixels; `background` is set, except behind moving parts.
        background: the static background.
        effects: shadows and beams at this time.
        projection: projection of the camera.
        rectangle: x0, y0, x1, y1 [px].
        supersample: sub-pixels per pixel and axis.
    """
    x0, y0, x1, y1 = rectangle
    lights = len(canvas.lit)
    factors, uneven = np.empty(1 + lights), np.empty(lights, np.bool_)
    factors[0], share = effects.gains[0], np.ones(1 + lights)
    active = np.empty(len(effects.light), np.int64)
    for row in range(y0, y1):
        for column in range(x0, x1):
            if not canvas.scratch[np.uintp(row), np.uintp(column)]:
                continue
            if canvas.pixel_label[np.uintp(row), np.uintp(column)] >= 0:
                continue  # a moving part hides it
            full = effects.gains[0] == 1.0
            for light in range(lights):
                uneven[light] = not _evenly_lit(canvas.lit, light, row, column, rectangle)
                factor = effects.gains[1 + light]
                if not uneven[light]:
                    factor *= canvas.lit[light, np.uintp(row), np.uintp(column)]
                full &= factor == 1.0
                factors[1 + light] = factor
            in_beam = _near_beam(canvas.in_beam, row, column, rectangle)
            shadows = 0
            for shadow in range(len(effects.light)):
                area = effects.shadow_areas[shadow]
                here = area[0] <= column < area[2] and area[1] <= row < area[3]
                if here and uneven[effects.light[shadow]]:
                    active[shadows] = shadow
                    shadows += 1
            i, j = np.uintp(row), np.uintp(column)
            full &= shadows == 0 and not in_beam
            if full and canvas.untouched[i, j]:
                continue
            canvas.untouched[i, j] = full
            if shadows == 0 and not in_beam:
                _light_evenly(canvas, background, factors, row, column, supersample)
            else:
                _light_pointwise(
                    canvas,
                    background,
                    effects,
                    projection,
                    factors,
                    share,
                    active[:shadows],
                    in_beam,
                    row,
                    column,
                    supersample,
                )


@inlined
def _light_evenly(
    canvas: Canvas,
    background: Background,
    factors: npt.NDArray[np.float64],
    row: int,
    column: int,
    supersample: int,
) -> None:
    """Light the sub-pixels of a pixel: the layers of the background, weighted with `factors`."""
    layers = background.subpixels
    for i in range(row * supersample, (row + 1) * supersample):
        for j in range(column * supersample, (column + 1) * supersample):
            v, u = np.uintp(i), np.uintp(j)
            value = factors[0] * layers[v, u, 0]
            for light in range(1, len(factors)):
                value += factors[light] * layers[v, u, np.uintp(light)]
            canvas.background[v, u] = value


@inlined
def _light_pointwise(
    canvas: Canvas,
    background: Background,
    effects: ShadowsAndBeams,
    projection: Projection,
    factors: npt.NDArray[np.float64],
    share: npt.NDArray[np.float64],
    active: I64,
    in_beam: bool,
    row: int,
    column: int,
    supersample: int,
) -> None:
    """Light each sub-pixel of a pixel by itself.

    Args:
        canvas: `background` is set.
        background: the static background.
        effects: shadows and beams at this time.
        projection: projection of the camera.
        factors: (1 + lights,) factor of each layer where no shadow falls.
        share: (1 + lights,) scratch.
        active: numbers of the shadows that may end in the pixel.
        in_beam: True if beams may light the pixel.
        row: row of the pixel.
        column: column of the pixel.
        supersample: sub-pixels per pixel and axis.
    """
    focal, centre_x, centre_y = projection
    layers, normals = background.subpixels, background.normals
    maps, sizes, views, is_sun = effects.maps, effects.sizes, effects.views, effects.is_sun
    n_x, n_y, n_z = normals[row, column, 0], normals[row, column, 1], normals[row, column, 2]
    for i in range(row * supersample, (row + 1) * supersample):
        below = ((i + 0.5) / supersample - centre_y) / focal
        for j in range(column * supersample, (column + 1) * supersample):
            v, u = np.uintp(i), np.uintp(j)
            if canvas.label[v, u] >= 0:
                continue
            z = 1.0 / background.subpixel_nearness[v, u]
            x, y = ((j + 0.5) / supersample - centre_x) / focal * z, below * z
            share[:] = 1.0
            for k in range(len(active)):
                shadow = active[k]
                at = transform_point(views, shadow, x, y, z)
                share[1 + effects.light[shadow]] *= unshadowed_share(
                    maps, sizes, is_sun, shadow, at[0], at[1], at[2]
                )
            value = factors[0] * layers[v, u, 0]
            for light in range(1, len(factors)):
                value += factors[light] * share[light] * layers[v, u, np.uintp(light)]
            lux = 0.0
            if in_beam:
                for k in range(len(effects.beams)):
                    lux += beam_lux(effects.beams, k, effects.beam_range_m, x, y, z, n_x, n_y, n_z)
            canvas.background[v, u] = value + lux * background.subpixel_albedo[v, u]


@inlined
def _near_beam(in_beam: Bools, row: int, column: int, rectangle: Rectangle) -> bool:
    """Return True if a beam lights a pixel or one of its neighbours in a rectangle."""
    found = False
    for i in range(max(row - 1, rectangle[1]), min(row + 2, rectangle[3])):
        for j in range(max(column - 1, rectangle[0]), min(column + 2, rectangle[2])):
            found |= in_beam[np.uintp(i), np.uintp(j)]
    return found


@inlined
def _evenly_lit(lit: F32, light: int, row: int, column: int, rectangle: Rectangle) -> bool:
    """Return True if a pixel and its neighbours in a rectangle get equal shares of a light."""
    own, even = lit[light, row, column], True
    for i in range(max(row - 1, rectangle[1]), min(row + 2, rectangle[3])):
        for j in range(max(column - 1, rectangle[0]), min(column + 2, rectangle[2])):
            even &= lit[np.uintp(light), np.uintp(i), np.uintp(j)] == own
    return even
