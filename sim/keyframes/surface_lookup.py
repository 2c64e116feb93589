"""Luminance of a mover's surface at one point, interpolated between two keyframes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import inlined
from sim.geometry.pinhole import Projection
from sim.geometry.rigid_transform import transform_point

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]

MIN_COVERAGE = 1e-3
"""Coverage below which keyframes are taken not to show a point of a surface (assumed)."""


class Surfaces(NamedTuple):
    """Surfaces of all moving parts, as seen in the keyframes before and after the present time.

    The arrays have 2 · parts rows. The first half are the parts. The second half are the
    illuminations of the parts that rotate relative to the light, which have an albedo instead of a
    luminance in the first half.

    Attributes:
        luminance: (n,) float32, coverage × luminance of all patches, flattened [cd/m²]; for a part
            that rotates, coverage × albedo, and separately its illumination, which does not rotate.
        coverage: (n,) float32.
        patches: (2 · parts, 2, 5) int64, for both keyframes: start in `luminance`, x0, y0 [grid
            points], width and height; width 0 if there is no patch.
        transforms: (4 · parts, 3, 4) float64, two for each row: from the camera's frame now to its
            frame at either keyframe.
        weights: (2 · parts, 2) float64, weights of the two keyframes, which sum to 1.
        means: (2 · parts,) float64, value for points that no keyframe shows.
        per_pixel: grid points per pixel and axis.
    """

    luminance: F32
    coverage: F32
    patches: I64
    transforms: F64
    weights: F64
    means: F64
    per_pixel: int


@inlined
def surface_luminance(
    surfaces: Surfaces,
    projection: Projection,
    part: int,
    u: float,
    v: float,
    depth: float,
    off_u: float,
    off_v: float,
) -> float:
    """Return the luminance of a part around a pixel centre, from the keyframes [cd/m²].

    Args:
        surfaces: surfaces of all parts.
        projection: projection of the camera.
        part: number of the part.
        u: column of a point of the part in the image [px].
        v: row of the point [px].
        depth: depth of the point [m].
        off_u: columns from the pixel centre to the point [px].
        off_v: rows from the pixel centre to the point [px].
    """
    value = 1.0
    for layer in range(2):
        row = part + layer * (len(surfaces.means) // 2)
        if layer == 1 and surfaces.patches[row, 0, 3] + surfaces.patches[row, 1, 3] == 0:
            break
        here = _interpolated(surfaces, projection, row, u, v, depth, off_u, off_v)
        value *= surfaces.means[row] if here < 0.0 else here
    return value


@inlined
def _interpolated(
    surfaces: Surfaces,
    projection: Projection,
    row: int,
    u: float,
    v: float,
    depth: float,
    off_u: float,
    off_v: float,
) -> float:
    """Interpolate one row of the surfaces around a pixel centre; see `surface_luminance`.

    Returns:
        Luminance, albedo or illumination; negative if no keyframe shows the point.
    """
    luminance, coverage, patches, transforms, weights, _, per_pixel = surfaces
    focal, centre_x, centre_y = projection
    x, y = (u - centre_x) / focal * depth, (v - centre_y) / focal * depth
    total = weight = 0.0
    for key in range(2):
        share = weights[row, key]
        width, height = patches[row, key, 3], patches[row, key, 4]
        if share <= 0.0 or width == 0:
            continue
        there_x, there_y, there_z = transform_point(transforms, 2 * row + key, x, y, depth)
        if there_z <= 0.0:
            continue
        column = (centre_x + focal * there_x / there_z - off_u) * per_pixel - 0.5
        line = (centre_y + focal * there_y / there_z - off_v) * per_pixel - 0.5
        left, top = math.floor(column), math.floor(line)
        across, down = column - left, line - top
        left -= patches[row, key, 1]
        top -= patches[row, key, 2]
        if left < 0 or top < 0 or left + 1 >= width or top + 1 >= height:
            continue
        at = patches[row, key, 0] + top * width + left
        a, b = share * (1.0 - across) * (1.0 - down), share * across * (1.0 - down)
        c, d = share * (1.0 - across) * down, share * across * down
        total += a * luminance[at] + b * luminance[at + 1]
        total += c * luminance[at + width] + d * luminance[at + width + 1]
        weight += a * coverage[at] + b * coverage[at + 1]
        weight += c * coverage[at + width] + d * coverage[at + width + 1]
    return total / weight if weight > MIN_COVERAGE else -1.0
