"""Luminance of a mover's surface at one point, interpolated between two keyframes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined
from sim.geometry.pinhole import Projection

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]

MIN_COVERAGE = 1e-3
"""Coverage below which keyframes are taken not to show a point of a surface (assumed)."""


class Surfaces(NamedTuple):
    """Surfaces of all moving parts, as seen in the keyframes before and after the present time.

    The arrays have 2 · parts rows. The first half are the parts. The second half are the
    illuminations of the parts that rotate relative to the light, which have an albedo instead of a
    luminance in the first half.

    Attributes:
        grid: (n, 2) float32, coverage × luminance of all patches, flattened [cd/m²], and coverage;
            for a part that rotates, coverage × albedo, and separately its illumination, which does
            not rotate.
        patches: (2 · parts, 2, 5) int64, for both keyframes: start in `grid`, x0, y0 [grid points],
            width and height; width 0 if there is no patch.
        views: (2 · parts, 2, 3, 4) float64 transform from the carrying body's frame to the camera's
            at both keyframes.
        carriers: (2 · parts,) int32 number of the body that carries each row.
        key_us: (2 · parts, 2) int64 times of both keyframes [µs]; equal if there is only one.
        means: (2 · parts,) float64, value for points that no keyframe shows.
        per_pixel: grid points per pixel and axis.
        matrices: (2 · parts, 2, 3, 4) float64 map from (column, row, 1, nearness) of a point in the
            present image to its homogeneous position in a patch; see `move_surfaces`.
        weights: (2 · parts, 2) float64, weights of the two keyframes, which sum to 1.
    """

    grid: F32
    patches: I64
    views: F64
    carriers: I32
    key_us: I64
    means: F64
    per_pixel: int
    matrices: F64
    weights: F64


@compiled
def move_surfaces(surfaces: Surfaces, t_us: int, views: F64, projection: Projection) -> None:
    """Set matrices and weights of surfaces for a time.

    A point at (u, v) in the image has the position (u', v', 1) / nearness in the camera's frame. A
    rigid motion followed by a projection is therefore linear in (u, v, 1, nearness), up to one
    division.

    Args:
        surfaces: the surfaces; `matrices` and `weights` are changed.
        t_us: the time [µs].
        views: (bodies, 3, 4) transform from each body's frame to the camera's at that time.
        projection: projection of the camera.
    """
    focal, centre_x, centre_y = projection
    linear = np.empty((3, 4))
    for row in range(len(surfaces.means)):
        first, last = surfaces.key_us[row, 0], surfaces.key_us[row, 1]
        late = min(max((t_us - first) / (last - first), 0.0), 1.0) if last > first else 0.0
        surfaces.weights[row, 0], surfaces.weights[row, 1] = 1.0 - late, late
        now = views[surfaces.carriers[row]]
        for key in range(2):
            x0, y0 = surfaces.patches[row, key, 1], surfaces.patches[row, key, 2]
            if surfaces.patches[row, key, 3] == 0:
                continue
            then = surfaces.views[row, key]
            for a in range(3):
                for b in range(3):  # rotation: then · nowᵀ
                    linear[a, b] = 0.0
                    for c in range(3):
                        linear[a, b] += then[a, c] * now[b, c]
                linear[a, 3] = then[a, 3]
                for b in range(3):
                    linear[a, 3] -= linear[a, b] * now[b, 3]
                right, down = linear[a, 0] / focal, linear[a, 1] / focal
                linear[a, 2] -= right * centre_x + down * centre_y
                linear[a, 0], linear[a, 1] = right, down
            size = surfaces.per_pixel
            for b in range(4):
                x, y, z = linear[0, b], linear[1, b], linear[2, b]
                matrix = surfaces.matrices[row, key]
                matrix[0, b] = size * (centre_x * z + focal * x) - (0.5 + x0) * z
                matrix[1, b] = size * (centre_y * z + focal * y) - (0.5 + y0) * z
                matrix[2, b] = z


@compiled
def surface_run(
    surfaces: Surfaces,
    part: int,
    row: int,
    start: int,
    end: int,
    nearness: F32,
    scratch: F64,
    out: F32,
) -> None:
    """Look up a part at the centres of several pixels of a row.

    Args:
        surfaces: surfaces of all parts, moved to the present time.
        part: number of the part.
        row: row of the pixels.
        start: first pixel.
        end: pixel after the last.
        nearness: (columns,) nearness along the row of sub-pixels at or just after the pixels'
            centres [1/m].
        scratch: (4, at least `end`), overwritten.
        out: (width,) luminance of the row; set at these pixels [cd/m²].
    """
    value, coverage = scratch[0], scratch[1]
    for layer in range(2):
        k = part + layer * (len(surfaces.means) // 2)
        if layer == 1 and surfaces.patches[k, 0, 3] + surfaces.patches[k, 1, 3] == 0:
            break
        scratch[:2, start:end] = 0.0
        for key in range(2):
            if surfaces.weights[k, key] > 0.0 and surfaces.patches[k, key, 3] > 0:
                _find_in_patch(surfaces, k, key, row, start, end, nearness, scratch)
                _add_patch(surfaces, k, key, start, end, scratch)
        mean = surfaces.means[k]
        for column in range(start, end):
            j = np.uintp(column)
            here = value[j] / coverage[j] if coverage[j] > MIN_COVERAGE else mean
            out[j] = here if layer == 0 else out[j] * here


@inlined
def _find_in_patch(
    surfaces: Surfaces,
    k: int,
    key: int,
    row: int,
    start: int,
    end: int,
    nearness: F32,
    scratch: F64,
) -> None:
    """Set rows 2 and 3 of `scratch` to the columns and rows of pixels in a patch.

    See `surface_run`. A point behind the camera gets a column of −1.
    """
    m, size = surfaces.matrices[k, key], surfaces.per_pixel
    centre = size // 2
    shift = centre + 0.5 - size / 2
    off, v = 0.5 + shift / size, row + 0.5 + shift / size
    x_u, x_row, x_near = m[0, 0], m[0, 1] * v + m[0, 2], m[0, 3]
    y_u, y_row, y_near = m[1, 0], m[1, 1] * v + m[1, 2], m[1, 3]
    z_u, z_row, z_near = m[2, 0], m[2, 1] * v + m[2, 2], m[2, 3]
    x, y = scratch[2], scratch[3]
    for column in range(start, end):
        j, u = np.uintp(column), column + off
        near = nearness[np.uintp(column * size + centre)]
        depth = z_u * u + z_row + z_near * near
        scale = 1.0 / depth
        across = (x_u * u + x_row + x_near * near) * scale - shift
        x[j] = across if depth > 0.0 else -1.0
        y[j] = (y_u * u + y_row + y_near * near) * scale - shift


@inlined
def _add_patch(surfaces: Surfaces, k: int, key: int, start: int, end: int, scratch: F64) -> None:
    """Add what one keyframe shows of row `k` of the surfaces; see `surface_run`."""
    grid, patch, share = surfaces.grid, surfaces.patches[k, key], surfaces.weights[k, key]
    first, width, height = patch[0], patch[3], patch[4]
    for column in range(start, end):
        j = np.uintp(column)
        x, y = scratch[2, j], scratch[3, j]
        if x >= 0.0 and y >= 0.0 and x < width - 1 and y < height - 1:
            value, coverage = _bilinear(grid, first, width, x, y)
            scratch[0, j] += share * value
            scratch[1, j] += share * coverage


@inlined
def _bilinear(grid: F32, first: int, width: int, x: float, y: float) -> tuple[float, float]:
    """Interpolate a patch at a column and row inside it: coverage × luminance, and coverage."""
    left, top = int(x), int(y)
    across, down = x - left, y - top
    at, step = np.uintp(first + top * width + left), np.uintp(1)
    below = at + np.uintp(width)
    a, b = (1.0 - across) * (1.0 - down), across * (1.0 - down)
    c, d = (1.0 - across) * down, across * down
    value = a * grid[at, 0] + b * grid[at + step, 0]
    value += c * grid[below, 0] + d * grid[below + step, 0]
    coverage = a * grid[at, 1] + b * grid[at + step, 1]
    coverage += c * grid[below, 1] + d * grid[below + step, 1]
    return value, coverage


@inlined
def surface_luminance(
    surfaces: Surfaces,
    part: int,
    u: float,
    v: float,
    nearness: float,
    shift_u: float,
    shift_v: float,
) -> float:
    """Return the luminance of a part around a pixel centre, from the keyframes [cd/m²].

    Args:
        surfaces: surfaces of all parts, moved to the present time.
        part: number of the part.
        u: column of a point of the part in the image [px].
        v: row of the point [px].
        nearness: 1/depth of the point [1/m].
        shift_u: columns from the pixel centre to the point [grid points].
        shift_v: rows from the pixel centre to the point [grid points].
    """
    value = 1.0
    for layer in range(2):
        row = part + layer * (len(surfaces.means) // 2)
        if layer == 1 and surfaces.patches[row, 0, 3] + surfaces.patches[row, 1, 3] == 0:
            break
        here = _interpolated(surfaces, row, u, v, nearness, shift_u, shift_v)
        value *= surfaces.means[row] if here < 0.0 else here
    return value


@inlined
def _interpolated(
    surfaces: Surfaces,
    row: int,
    u: float,
    v: float,
    nearness: float,
    shift_u: float,
    shift_v: float,
) -> float:
    """Interpolate one row of the surfaces around a pixel centre; see `surface_luminance`.

    Returns:
        Luminance, albedo or illumination; negative if no keyframe shows the point.
    """
    grid, patches, matrices = surfaces.grid, surfaces.patches, surfaces.matrices
    k, total, weight = np.uintp(row), 0.0, 0.0
    for key in range(2):
        q = np.uintp(key)
        share, width, height = surfaces.weights[k, q], patches[k, q, 3], patches[k, q, 4]
        if share <= 0.0 or width == 0:
            continue
        m = matrices[k, q]
        depth = m[2, 0] * u + m[2, 1] * v + m[2, 2] + m[2, 3] * nearness
        if depth <= 0.0:
            continue
        scale = 1.0 / depth
        x = (m[0, 0] * u + m[0, 1] * v + m[0, 2] + m[0, 3] * nearness) * scale - shift_u
        y = (m[1, 0] * u + m[1, 1] * v + m[1, 2] + m[1, 3] * nearness) * scale - shift_v
        if not (x >= 0.0 and y >= 0.0 and x < width - 1 and y < height - 1):
            continue
        value, coverage = _bilinear(grid, patches[k, q, 0], width, x, y)
        total += share * value
        weight += share * coverage
    return total / weight if weight > MIN_COVERAGE else -1.0
