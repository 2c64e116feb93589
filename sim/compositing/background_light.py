"""Light on the background: shadows and beams at pixel centres, and at sub-pixels near edges.

Kernels work along a row of points of which only the column differs, so that most of their loops can
be vectorised.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined
from sim.compositing.background import Background
from sim.compositing.canvas import Canvas
from sim.compositing.pixel_labels import EDGE
from sim.geometry.pinhole import Projection
from sim.geometry.rectangles import Rectangle
from sim.shadows.point_illumination import (
    Row,
    beam_lux,
    beam_of,
    find_unshadowed_shares,
)
from sim.shadows.shadows_and_beams import ShadowsAndBeams

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

Run = tuple[int, int, int, int]
"""Neighbouring pixels: row, first column, column after the last, sub-pixels per pixel and axis."""


@inlined
def _row_of_points(projection: Projection, row: int, size: int) -> Row:
    """Return a row of a grid with `size` points per pixel and axis."""
    focal, centre_x, centre_y = projection
    step = 1.0 / (size * focal)
    return ((row + 0.5) / size - centre_y) / focal, (0.5 / size - centre_x) / focal, step


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
        canvas: `lit`, `shadowed` and `in_beam` are set; shadows are added to `pixel_label`, see
            `_add_shadow`.
        background: the static background.
        effects: shadows and beams at this time.
        projection: projection of the camera.
        rectangle: x0, y0, x1, y1 [px].
    """
    x0, y0, x1, y1 = rectangle
    canvas.lit[:, y0:y1, x0:x1] = 1.0
    canvas.shadowed[y0:y1, x0:x1] = 0
    canvas.in_beam[y0:y1, x0:x1] = False
    shares = np.empty((3, x1))
    for shadow in range(len(effects.light)):
        _add_shadow(canvas, background.nearness, effects, shadow, projection, rectangle, shares)
    for beam in range(len(effects.beams)):
        _add_beam(canvas, background, effects, beam, projection, rectangle)


@inlined
def _add_shadow(
    canvas: Canvas,
    nearness: F32,
    effects: ShadowsAndBeams,
    shadow: int,
    projection: Projection,
    rectangle: Rectangle,
    shares: F64,
) -> None:
    """Apply one shadow to the background at the pixel centres of a rectangle.

    The shadow multiplies `canvas.lit`, and sets its bit in `canvas.shadowed` where it falls. In
    `canvas.pixel_label`, a negative label is background, where each shadow has a bit of −1 − label,
    which is set where it is complete. A partial shadow gives `EDGE`.
    """
    area, pixel_label = effects.shadow_areas[shadow], canvas.pixel_label
    lit = canvas.lit[effects.light[shadow]]
    start, end = max(area[0], rectangle[0]), min(area[2], rectangle[2])
    for row in range(max(area[1], rectangle[1]), min(area[3], rectangle[3])):
        i = np.uintp(row)
        points = _row_of_points(projection, row, 1)
        find_unshadowed_shares(effects, shadow, points, nearness[i], start, end, shares)
        for column in range(start, end):
            j = np.uintp(column)
            label, share = pixel_label[i, j], shares[0, j]
            if label >= 0 or share >= 1.0:
                continue
            lit[i, j] *= share
            canvas.shadowed[i, j] |= 1 << shadow
            if label != EDGE:
                pixel_label[i, j] = EDGE if share > 0.0 else label - (1 << shadow)


@inlined
def _add_beam(
    canvas: Canvas,
    background: Background,
    effects: ShadowsAndBeams,
    beam: int,
    projection: Projection,
    rectangle: Rectangle,
) -> None:
    """Set `canvas.in_beam` where a beam lights the background at the pixel centre."""
    of_beam, area, range_m = (
        beam_of(effects.beams, beam),
        effects.beam_areas[beam],
        effects.beam_range_m,
    )
    nearness, normals = background.nearness, background.normals
    for row in range(max(area[1], rectangle[1]), min(area[3], rectangle[3])):
        i, (y, left, step) = np.uintp(row), _row_of_points(projection, row, 1)
        for column in range(max(area[0], rectangle[0]), min(area[2], rectangle[2])):
            j, x = np.uintp(column), left + column * step
            normal = normals[0, i, j], normals[1, i, j], normals[2, i, j]
            lux = beam_lux(of_beam, range_m, x, y, nearness[i, j], normal)
            canvas.in_beam[i, j] |= (lux > 0.0) & (canvas.pixel_label[i, j] < 0)


class RowPlan(NamedTuple):
    """How the sub-pixels of a row of pixels are lit.

    Attributes:
        wanted: (columns,) bool, pixels whose sub-pixels must be set.
        share: (lights, columns) factor of each layer but the first, without the shadows below.
        shadows: (columns,) int64, a bit for each shadow that may end in the pixel.
        in_beam: (columns,) bool, pixels that beams may light.
    """

    wanted: Bools
    share: F64
    shadows: I64
    in_beam: Bools


class Scratch(NamedTuple):
    """Buffers for a row of sub-pixels.

    Attributes:
        share: (lights, columns) factor of each layer but the first.
        shares: (3, columns) share of a light that passes a moving object, and scratch.
        normals: (3, columns) normals of the background.
        lux: (columns,) illuminance from beams.
    """

    share: F64
    shares: F64
    normals: F64
    lux: F64


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
        canvas: `scratch` marks the pixels; `background` is set, except in pixels that a moving part
            hides entirely.
        background: the static background.
        effects: shadows and beams at this time.
        projection: projection of the camera.
        rectangle: x0, y0, x1, y1 [px].
        supersample: sub-pixels per pixel and axis.
    """
    x0, y0, x1, y1 = rectangle
    lights, columns = len(canvas.lit), x1 * supersample
    plan = RowPlan(
        np.empty(x1, np.bool_),
        np.empty((lights, x1)),
        np.empty(x1, np.int64),
        np.empty(x1, np.bool_),
    )
    scratch = Scratch(
        np.empty((lights, columns)),
        np.empty((3, columns)),
        np.empty((3, columns)),
        np.empty(columns),
    )
    for row in range(y0, y1):
        _plan_row(canvas, effects, row, rectangle, plan)
        column = x0
        while column < x1:
            end = column
            while end < x1 and plan.wanted[end]:
                end += 1
            if end > column:
                run = row, column, end, supersample
                _light_run(canvas, background, effects, projection, plan, run, scratch)
            column = end + 1


@inlined
def _plan_row(
    canvas: Canvas, effects: ShadowsAndBeams, row: int, rectangle: Rectangle, plan: RowPlan
) -> None:
    """Set the plan of a row of a rectangle."""
    even = True
    for gain in effects.gains:
        even &= gain == 1.0
    i = np.uintp(row)
    for column in range(rectangle[0], rectangle[2]):
        j = np.uintp(column)
        plan.wanted[j] = canvas.scratch[i, j] and canvas.pixel_label[i, j] < 0
        if not plan.wanted[j]:
            continue
        shadows, in_beam = _effects_near(canvas, row, column, rectangle)
        full, ends = even and not in_beam and shadows == 0, 0
        for light in range(len(canvas.lit)):
            plan.share[light, j] = effects.gains[1 + light]
            if shadows != 0:
                if _evenly_lit(canvas.lit, light, row, column, rectangle):
                    plan.share[light, j] *= canvas.lit[light, i, j]
                else:
                    for shadow in range(len(effects.light)):
                        if effects.light[shadow] == light:
                            ends |= shadows & (1 << shadow)
        plan.shadows[j], plan.in_beam[j] = ends, in_beam
        plan.wanted[j] = not (full and canvas.untouched[i, j])
        canvas.untouched[i, j] = full


@inlined
def _light_run(
    canvas: Canvas,
    background: Background,
    effects: ShadowsAndBeams,
    projection: Projection,
    plan: RowPlan,
    run: Run,
    scratch: Scratch,
) -> None:
    """Set the luminance of the background at the sub-pixels of a run of pixels."""
    row, start, end, size = run
    share, layers, first, last = scratch.share, background.subpixels, start * size, end * size
    shadows, in_beam = 0, False
    for column in range(start, end):
        shadows |= plan.shadows[np.uintp(column)]
        in_beam |= plan.in_beam[np.uintp(column)]
    if in_beam:
        for axis in range(3):
            for column in range(start, end):
                normal = background.normals[axis, row, np.uintp(column)]
                for j in range(column * size, (column + 1) * size):
                    scratch.normals[axis, np.uintp(j)] = normal
    for i in range(row * size, (row + 1) * size):
        v, points = np.uintp(i), _row_of_points(projection, i, size)
        nearness = background.subpixel_nearness[v]
        for light in range(len(share)):
            for column in range(start, end):
                factor = plan.share[light, np.uintp(column)]
                for j in range(column * size, (column + 1) * size):
                    share[light, np.uintp(j)] = factor
        if shadows != 0:
            _shade_run(effects, plan, run, points, nearness, shadows, scratch)
        for j in range(first, last):
            u = np.uintp(j)
            canvas.background[v, u] = effects.gains[0] * layers[0, v, u]
        for light in range(len(share)):
            for j in range(first, last):
                u = np.uintp(j)
                canvas.background[v, u] += share[light, u] * layers[1 + light, v, u]
        if in_beam:
            _sum_beams(effects, points, nearness, first, last, scratch)
            for j in range(first, last):
                u = np.uintp(j)
                canvas.background[v, u] += scratch.lux[u] * background.subpixel_albedo[v, u]


@inlined
def _shade_run(
    effects: ShadowsAndBeams,
    plan: RowPlan,
    run: Run,
    points: Row,
    nearness: F32,
    shadows: int,
    scratch: Scratch,
) -> None:
    """Apply the shadows that end in the pixels of a run to a row of their sub-pixels."""
    _, start, end, size = run
    shares = scratch.shares
    for shadow in range(len(effects.light)):
        if shadows >> shadow & 1 == 0:
            continue
        share, column = scratch.share[effects.light[shadow]], start
        while column < end:
            stop = column
            while stop < end and plan.shadows[np.uintp(stop)] >> shadow & 1:
                stop += 1
            if stop > column:
                first, last = column * size, stop * size
                find_unshadowed_shares(effects, shadow, points, nearness, first, last, shares)
                for j in range(first, last):
                    share[np.uintp(j)] *= shares[0, np.uintp(j)]
            column = stop + 1


@inlined
def _sum_beams(
    effects: ShadowsAndBeams, points: Row, nearness: F32, start: int, end: int, scratch: Scratch
) -> None:
    """Set `scratch.lux` to the illuminance from all beams at points of a row."""
    y, left, step = points
    lux, normals = scratch.lux, scratch.normals
    lux[start:end] = 0.0
    for k in range(len(effects.beams)):
        beam = beam_of(effects.beams, k)
        for j in range(start, end):
            u = np.uintp(j)
            normal = normals[0, u], normals[1, u], normals[2, u]
            lux[u] += beam_lux(beam, effects.beam_range_m, left + j * step, y, nearness[u], normal)


@inlined
def _effects_near(canvas: Canvas, row: int, column: int, rectangle: Rectangle) -> tuple[int, bool]:
    """Return the shadows and beams at a pixel and its neighbours in a rectangle.

    Returns:
        A bit for each shadow, and True if there is a beam.
    """
    shadows, in_beam = 0, False
    for i in range(max(row - 1, rectangle[1]), min(row + 2, rectangle[3])):
        for j in range(max(column - 1, rectangle[0]), min(column + 2, rectangle[2])):
            shadows |= canvas.shadowed[np.uintp(i), np.uintp(j)]
            in_beam |= canvas.in_beam[np.uintp(i), np.uintp(j)]
    return shadows, in_beam


@inlined
def _evenly_lit(lit: F32, light: int, row: int, column: int, rectangle: Rectangle) -> bool:
    """Return True if a pixel and its neighbours in a rectangle get equal shares of a light."""
    own, even = lit[light, row, column], True
    for i in range(max(row - 1, rectangle[1]), min(row + 2, rectangle[3])):
        for j in range(max(column - 1, rectangle[0]), min(column + 2, rectangle[2])):
            even &= lit[np.uintp(light), np.uintp(i), np.uintp(j)] == own
    return even
