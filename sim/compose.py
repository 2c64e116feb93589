"""One sample's image: the still street under its lights, and over it what moves.

A pixel holds S × S points of the fine grid on which geometry is known exactly. Where a pixel and
its neighbours show but one thing, that thing's light is known already for a whole pixel; only
where edges run are points weighed one by one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

Window = tuple[int, int, int, int]

EDGE = -(1 << 30)
"""Code of a pixel that shows more than one thing."""
MOST_SHADOWS = 29
"""Pairs of light and mover whose state fits a pixel's code."""
LEAST_COVER = 1e-3
"""Keyframes that show less of a surface around a place know nothing of it (assumed)."""
BIAS_M, BIAS = 2e-3, 1e-4
"""How much nearer to its light a caster must be than what it darkens: in parallel light [m], and
relative to the distance from a lamp (assumed)."""


class Street(NamedTuple):
    """What never moves, by light.

    Attributes:
        pixels: (1 + lights, height, width) float32 [cd/m²]: what comes steadily, then what each
            light that casts shadows adds where nothing is in its way.
        points: the same on the fine grid, but (rows, columns, 1 + lights): they are read point by
            point.
        albedo_points: fine grid, float32 [cd/m² a lux].
        nearness: fine grid, 1/depth [1/m], float32.
        depth: (height, width) float32 at the pixels' middles [m].
        normals: (height, width, 3) float32 at the pixels' middles, in the camera's frame.
    """

    pixels: F32
    points: F32
    albedo_points: F32
    nearness: F32
    depth: F32
    normals: F32


class Lights(NamedTuple):
    """The lights at a sample's time, in the camera's frame: right, down, forward [m].

    Attributes:
        gains: (1 + lights,) float64, what each part of the street is multiplied by.
        maps: (shadows, rows, columns) float32, how near to its light a mover is; one map for
            each pair of light and mover.
        sizes: (shadows, 2) int64, rows and columns of each map that are in use.
        views: (shadows, 3, 4) float64, from the camera's frame to the map's columns, rows and
            nearness; homogeneous for a lamp.
        light: (shadows,) int64, which light is shadowed.
        parallel: (shadows,) bool, whether that is the sun.
        reach: (shadows, 4) int64, x0, y0, x1, y1 of what each can darken [px].
        beams: (n, 9) float64: place, direction, candela, and scale and offset of the cone's edge.
        beam_reach: (n, 4) int64, x0, y0, x1, y1 of what each can light [px].
        beam_range_m: where the beams end.
    """

    gains: F64
    maps: F32
    sizes: I64
    views: F64
    light: I64
    parallel: Bools
    reach: I64
    beams: F64
    beam_reach: I64
    beam_range_m: float


class Surfaces(NamedTuple):
    """How the movers' surfaces looked at the keyframes before and after.

    Attributes:
        light: (n,) float32, cover × luminance of all pieces, flattened [cd/m²]; of a body that
            turns in its light, cover × albedo, and then that light, which does not turn with it.
        cover: (n,) float32.
        pieces: (2 · parts, 2, 5) int64: start in these, x0, y0 [grid points], width, height; width
            0 where there is none. The first half are the movers' parts, the second the light on
            each that turns in it.
        moves: (4 · parts, 3, 4) float64, two for each of these: from the camera's frame now to
            that at either keyframe.
        shares: (2 · parts, 2) float64, the two keyframes' shares, which sum to 1.
        means: (2 · parts,) float64, what is taken where no keyframe shows a place.
        per_pixel: grid points per pixel and axis.
    """

    light: F32
    cover: F32
    pieces: I64
    moves: F64
    shares: F64
    means: F64
    per_pixel: int


class Eye(NamedTuple):
    """The camera's geometry [pixels]."""

    focal: float
    centre_x: float
    centre_y: float


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _moved(moves: F64, k: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A point after move `k` of (n, 3, 4)."""
    return (
        moves[k, 0, 0] * x + moves[k, 0, 1] * y + moves[k, 0, 2] * z + moves[k, 0, 3],
        moves[k, 1, 0] * x + moves[k, 1, 1] * y + moves[k, 1, 2] * z + moves[k, 1, 3],
        moves[k, 2, 0] * x + moves[k, 2, 1] * y + moves[k, 2, 2] * z + moves[k, 2, 3],
    )


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _lit(
    maps: F32, sizes: I64, parallel: Bools, shadow: int, u: float, v: float, w: float
) -> float:
    """Share of a light, 0 to 1, that a mover lets through to a point.

    Args:
        maps: as in `Lights`, and so the next two.
        sizes: likewise.
        parallel: likewise.
        shadow: which.
        u: the point's column in the map; before a lamp, times its distance along the axis.
        v: its row likewise.
        w: in parallel light its nearness, before a lamp that distance [m].
    """
    if parallel[shadow]:
        near = w + BIAS_M
        w = 1.0
    elif w <= 0.0:
        return 1.0
    else:
        near = (1.0 + BIAS) / w
    rows, columns = sizes[shadow, 0], sizes[shadow, 1]
    if u < 0.5 * w or v < 0.5 * w or u >= (columns - 1.5) * w or v >= (rows - 1.5) * w:
        return 1.0
    u, v = u / w - 0.5, v / w - 0.5
    column, row = int(u), int(v)
    right, down = u - column, v - row
    lit = 0.0
    if maps[shadow, row, column] <= near:
        lit += (1.0 - right) * (1.0 - down)
    if maps[shadow, row, column + 1] <= near:
        lit += right * (1.0 - down)
    if maps[shadow, row + 1, column] <= near:
        lit += (1.0 - right) * down
    if maps[shadow, row + 1, column + 1] <= near:
        lit += right * down
    return lit


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _beam_lux(
    beams: F64,
    k: int,
    reach_m: float,
    x: float,
    y: float,
    z: float,
    normal_x: float,
    normal_y: float,
    normal_z: float,
) -> float:
    """Illuminance that one of the movers' lamps gives a surface [lux]."""
    dx, dy, dz = x - beams[k, 0], y - beams[k, 1], z - beams[k, 2]
    along = dx * beams[k, 3] + dy * beams[k, 4] + dz * beams[k, 5]
    across = -(dx * normal_x + dy * normal_y + dz * normal_z)
    if along <= 0.0 or across <= 0.0:
        return 0.0
    square = dx * dx + dy * dy + dz * dz
    if (along * beams[k, 7]) ** 2 <= beams[k, 8] * beams[k, 8] * square:
        return 0.0  # outside of the cone, and no need of a root
    distance = math.sqrt(square)
    edge = along / distance * beams[k, 7] + beams[k, 8]
    if edge <= 0.0:
        return 0.0
    edge = min(edge, 1.0)
    fade = square / (reach_m * reach_m)
    fade = max(1.0 - fade * fade, 0.0)
    lux: float = beams[k, 6] * edge * edge * fade * fade * across / distance / max(square, 1e-4)
    return lux


@njit(cache=True, nogil=True, error_model="numpy")
def _looked_up(
    light: F32,
    cover: F32,
    pieces: I64,
    moves: F64,
    shares: F64,
    per_pixel: int,
    focal: float,
    centre_x: float,
    centre_y: float,
    body: int,
    u: float,
    v: float,
    depth: float,
    off_u: float,
    off_v: float,
) -> float:
    """What the keyframes hold of a body around a pixel's middle.

    Args:
        light: as in `Surfaces`, and so the next four.
        cover: likewise.
        pieces: likewise.
        moves: likewise.
        shares: likewise.
        per_pixel: likewise.
        focal: of the camera [px].
        centre_x: likewise.
        centre_y: likewise.
        body: which of the pieces.
        u: where the body is seen, column [px].
        v: row.
        depth: there [m].
        off_u: from the pixel's middle to there [px].
        off_v: likewise.

    Returns:
        Luminance, albedo or light; negative where no keyframe shows the place.
    """
    x, y = (u - centre_x) / focal * depth, (v - centre_y) / focal * depth
    total = weight = 0.0
    for key in range(2):
        share = shares[body, key]
        width, height = pieces[body, key, 3], pieces[body, key, 4]
        if share <= 0.0 or width == 0:
            continue
        there_x, there_y, there_z = _moved(moves, 2 * body + key, x, y, depth)
        if there_z <= 0.0:
            continue
        column = (centre_x + focal * there_x / there_z - off_u) * per_pixel - 0.5
        row = (centre_y + focal * there_y / there_z - off_v) * per_pixel - 0.5
        left, top = math.floor(column), math.floor(row)
        across, down = column - left, row - top
        left -= pieces[body, key, 1]
        top -= pieces[body, key, 2]
        if left < 0 or top < 0 or left + 1 >= width or top + 1 >= height:
            continue
        at = pieces[body, key, 0] + top * width + left
        a, b = share * (1.0 - across) * (1.0 - down), share * across * (1.0 - down)
        c, d = share * (1.0 - across) * down, share * across * down
        total += a * light[at] + b * light[at + 1]
        total += c * light[at + width] + d * light[at + width + 1]
        weight += a * cover[at] + b * cover[at + 1]
        weight += c * cover[at + width] + d * cover[at + width + 1]
    return total / weight if weight > LEAST_COVER else -1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _surface_light(
    light: F32,
    cover: F32,
    pieces: I64,
    moves: F64,
    shares: F64,
    means: F64,
    per_pixel: int,
    focal: float,
    centre_x: float,
    centre_y: float,
    body: int,
    u: float,
    v: float,
    depth: float,
    off_u: float,
    off_v: float,
) -> float:
    """Luminance of a body around a pixel's middle, from the keyframes [cd/m²].

    Args as those of `_looked_up`, and `means` as in `Surfaces`.
    """
    value = 1.0
    for part in range(2):
        what = body + part * (len(means) // 2)
        if part == 1 and pieces[what, 0, 3] + pieces[what, 1, 3] == 0:
            break
        here = _looked_up(
            light,
            cover,
            pieces,
            moves,
            shares,
            per_pixel,
            focal,
            centre_x,
            centre_y,
            what,
            u,
            v,
            depth,
            off_u,
            off_v,
        )
        value *= means[what] if here < 0.0 else here
    return value


@njit(cache=True, nogil=True, error_model="numpy")
def _pixel_codes(label: I32, size: int) -> I32:
    """(height, width) the body that each pixel shows, -1 for none, `EDGE` for several things."""
    code = np.empty((label.shape[0] // size, label.shape[1] // size), np.int32)
    for row in range(code.shape[0]):
        for column in range(code.shape[1]):
            first = label[row * size, column * size]
            for i in range(row * size, (row + 1) * size):
                for j in range(column * size, (column + 1) * size):
                    if label[i, j] != first:
                        first = EDGE
            code[row, column] = first
    return code


@njit(cache=True, nogil=True, error_model="numpy")
def _shade_middles(
    lights: Lights, shadow: int, eye: Eye, window: Window, depth: F32, code: I32, lit: F32
) -> None:
    """Let one shadow fall on the street at the pixels' middles.

    Args:
        lights: at this time.
        shadow: which of them.
        eye: the camera's.
        window: x0, y0, x1, y1 [px].
        depth: (height, width) of the street [m].
        code: (height, width) the body that a pixel shows; below 0, each shadow has a bit of
            −1 − code, set where it is complete; `EDGE` where one is partial.
        lit: (height, width) float32, which share of the light comes through; multiplied.
    """
    focal, centre_x, centre_y = eye
    maps, sizes, parallel, view = lights.maps, lights.sizes, lights.parallel, lights.views[shadow]
    u_right, v_right, w_right = view[0, 0] / focal, view[1, 0] / focal, view[2, 0] / focal
    x0, y0, x1, y1 = window
    reach = lights.reach[shadow]
    for row in range(max(reach[1], y0) - y0, min(reach[3], y1) - y0):
        below = (y0 + row + 0.5 - centre_y) / focal
        u_row = view[0, 1] * below + view[0, 2]
        v_row = view[1, 1] * below + view[1, 2]
        w_row = view[2, 1] * below + view[2, 2]
        for column in range(max(reach[0], x0) - x0, min(reach[2], x1) - x0):
            what = code[row, column]
            if what >= 0:
                continue
            z, right = depth[row, column], x0 + column + 0.5 - centre_x
            u = z * (u_right * right + u_row) + view[0, 3]
            v = z * (v_right * right + v_row) + view[1, 3]
            w = z * (w_right * right + w_row) + view[2, 3]
            share = _lit(maps, sizes, parallel, shadow, u, v, w)
            if share >= 1.0:
                continue
            lit[row, column] *= share
            if what != EDGE:
                code[row, column] = EDGE if share > 0.0 else what - (1 << shadow)


@njit(cache=True, nogil=True, error_model="numpy")
def _light_middles(
    street: Street, lights: Lights, eye: Eye, window: Window, code: I32
) -> tuple[F32, F32]:
    """How the street at the pixels' middles is lit; their codes learn of it.

    Returns:
        (lights, height, width) float32, share of each light that comes through, and
        (height, width) float32, what the movers' lamps add [lux].
    """
    x0, y0, x1, y1 = window
    depth = street.depth[y0:y1, x0:x1]
    lit = np.ones((len(lights.gains) - 1, *code.shape), np.float32)
    for shadow in range(len(lights.light)):
        _shade_middles(lights, shadow, eye, window, depth, code, lit[lights.light[shadow]])
    lux = np.zeros(code.shape, np.float32)
    for beam in range(len(lights.beams)):
        _beam_middles(lights, beam, street.normals, eye, window, depth, code, lux)
    return lit, lux


@njit(cache=True, nogil=True, error_model="numpy")
def _beam_middles(
    lights: Lights,
    beam: int,
    normals: F32,
    eye: Eye,
    window: Window,
    depth: F32,
    code: I32,
    lux: F32,
) -> None:
    """Add what one beam gives the street at the pixels' middles [lux]."""
    focal, centre_x, centre_y = eye
    beams, reach_m = lights.beams, lights.beam_range_m
    x0, y0, x1, y1 = window
    reach = lights.beam_reach
    for v in range(max(y0, reach[beam, 1]), min(y1, reach[beam, 3])):
        for u in range(max(x0, reach[beam, 0]), min(x1, reach[beam, 2])):
            if code[v - y0, u - x0] >= 0:
                continue
            z = depth[v - y0, u - x0]
            x, y = (u + 0.5 - centre_x) / focal * z, (v + 0.5 - centre_y) / focal * z
            n_x, n_y, n_z = normals[v, u, 0], normals[v, u, 1], normals[v, u, 2]
            lux[v - y0, u - x0] += _beam_lux(beams, beam, reach_m, x, y, z, n_x, n_y, n_z)


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_edges(code: I32, lux: F32) -> Bools:
    """Which pixels are to be weighed point by point: they, or neighbours, show several things."""
    height, width = code.shape
    mixed = np.empty(code.shape, np.bool_)  # a pixel and those left and right of it
    for row in range(height):
        for column in range(width):
            left, right = max(column - 1, 0), min(column + 1, width - 1)
            what, dark = code[row, column], lux[row, column] + lux[row, left] + lux[row, right]
            alike = code[row, left] == what and code[row, right] == what and what != EDGE
            mixed[row, column] = not alike or dark > 0.0
    marked = np.empty(code.shape, np.bool_)
    for row in range(height):
        above, below = max(row - 1, 0), min(row + 1, height - 1)
        for column in range(width):
            what = code[row, column]
            marked[row, column] = (
                mixed[row, column]
                or mixed[above, column]
                or mixed[below, column]
                or code[above, column] != what
                or code[below, column] != what
            )
    return marked


@njit(cache=True, nogil=True, error_model="numpy")
def _grown(marked: Bools) -> Bools:
    """Which pixels are marked, or have a neighbour that is."""
    height, width = marked.shape
    grown = np.zeros(marked.shape, np.bool_)
    for row in range(height):
        for column in range(width):
            if marked[row, column]:
                for i in range(max(row - 1, 0), min(row + 2, height)):
                    for j in range(max(column - 1, 0), min(column + 2, width)):
                        grown[i, j] = True
    return grown


@njit(cache=True, nogil=True, error_model="numpy")
def _near_any(lux: F32, row: int, column: int) -> bool:
    """Whether a pixel or a neighbour is above 0."""
    for i in range(max(row - 1, 0), min(row + 2, lux.shape[0])):
        for j in range(max(column - 1, 0), min(column + 2, lux.shape[1])):
            if lux[i, j] > 0:
                return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _evenly_lit(lit: F32, row: int, column: int, light: int) -> bool:
    """Whether a pixel and its neighbours get the same share of a light."""
    for i in range(max(row - 1, 0), min(row + 2, lit.shape[1])):
        for j in range(max(column - 1, 0), min(column + 2, lit.shape[2])):
            if lit[light, i, j] != lit[light, row, column]:
                return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _light_points(
    street: Street,
    lights: Lights,
    eye: Eye,
    window: Window,
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
    x0, y0, _, _ = window
    count, height, width = lit.shape
    points = np.empty(label.shape, np.float32)
    near = _grown(marked)
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
                                at = _moved(views, shadow, x, y, z)
                                share[source[shadow]] *= _lit(
                                    maps, sizes, parallel, shadow, at[0], at[1], at[2]
                                )
                    value = gains[0] * parts[v, u, 0]
                    for light in range(count):
                        value += gains[1 + light] * share[light] * parts[v, u, 1 + light]
                    if in_beam:
                        for k in range(len(beams)):
                            here = _beam_lux(beams, k, reach_m, x, y, z, n_x, n_y, n_z)
                            value += here * albedo[v, u]
                    points[i, j] = value
    return points


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_plain(
    image: F32,
    street: Street,
    gains: F64,
    surfaces: Surfaces,
    eye: Eye,
    window: Window,
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
    x0, y0, _, _ = window
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
                value = _surface_light(
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


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_edges(
    image: F32,
    surfaces: Surfaces,
    eye: Eye,
    window: Window,
    weights: F32,
    label: I32,
    nearness: F32,
    points: F32,
    marked: Bools,
) -> None:
    """Draw the pixels that show several things, each point with its weight in the aperture."""
    light, cover, pieces, moves, shares, means, per_pixel = surfaces
    focal, centre_x, centre_y = eye
    x0, y0, _, _ = window
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
                seen = _surface_light(
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


@njit(cache=True, nogil=True, error_model="numpy")
def compose(
    image: F32,
    street: Street,
    lights: Lights,
    surfaces: Surfaces,
    eye: Eye,
    label: I32,
    nearness: F32,
    weights: F32,
    window: Window,
) -> None:
    """Draw a window of the image, in place.

    Args:
        image: (height, width) float32 [cd/m²].
        street: what never moves.
        lights: at this time.
        surfaces: of the movers.
        eye: the camera's.
        label: fine points of the window, int32: which body is seen, -1 for the street.
        nearness: fine points of the window, float32 [1/m], where a body is seen.
        weights: (3 S,) the pixel's aperture along an axis.
        window: x0, y0, x1, y1 [px].
    """
    size = len(weights) // 3
    code = _pixel_codes(label, size)
    lit, lux = _light_middles(street, lights, eye, window, code)
    marked = _mark_edges(code, lux)
    points = _light_points(street, lights, eye, window, size, label, lit, lux, marked)
    _draw_plain(
        image, street, lights.gains, surfaces, eye, window, size, code, lit, nearness, marked
    )
    _draw_edges(image, surfaces, eye, window, weights, label, nearness, points, marked)
