"""A mover's surface at one place, looked up in the keyframes before and after."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.rigid_transform import transform_point

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]

LEAST_COVER = 1e-3
"""Keyframes that show less of a surface around a place know nothing of it (assumed)."""


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


@compiled
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
        there_x, there_y, there_z = transform_point(moves, 2 * body + key, x, y, depth)
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


@compiled
def surface_light(
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
