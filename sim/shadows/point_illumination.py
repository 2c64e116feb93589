"""Illumination of one point: the share of a light that reaches it, and a beam's illuminance."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import inlined
from sim.shadows.shadows_and_beams import ShadowsAndBeams

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

SUN_BIAS_M = 2e-3
"""How much nearer to the sun a caster must be than the point that it shades [m] (assumed)."""
LAMP_BIAS = 1e-4
"""How much nearer to a lamp a caster must be than the point that it shades, relative to the point's
distance from the lamp (assumed)."""
MIN_SQUARE_M2 = 1e-4
"""Least squared distance of a surface from a lamp [m²] (assumed)."""
MIN_SQUARE = 1e-30
"""The corresponding value, times a squared nearness, that keeps square roots from 0 (assumed)."""


Row = tuple[float, float, float]
"""A row of points in the image: y of all of them, x of the first, and the step from one to the
next, relative to the focal length and from the image's centre."""


@inlined
def find_unshadowed_shares(
    effects: ShadowsAndBeams,
    shadow: int,
    points: Row,
    nearness: F32,
    start: int,
    end: int,
    shares: F64,
) -> None:
    """Find the share of a light, 0 to 1, that passes a moving object and reaches points of a row.

    Args:
        effects: the shadows, in their maps.
        shadow: index of the shadow.
        points: the row.
        nearness: 1/depth of the points of the row [1/m].
        start: first point.
        end: point after the last.
        shares: (3, at least `end`); the first row is set to the shares, the others are overwritten.
    """
    view, is_sun = effects.views[shadow], effects.is_sun[shadow]
    find_texels(view, is_sun, points, nearness, start, end, shares)
    rows, columns = effects.sizes[shadow, 0] - 2, effects.sizes[shadow, 1] - 2
    texels, width = effects.maps[shadow].ravel(), effects.maps.shape[2]
    for j in range(start, end):
        k = np.uintp(j)
        u, v, near = shares[0, k], shares[1, k], shares[2, k]
        shares[0, k] = 1.0
        if not (u >= 0.0 and v >= 0.0 and u < columns and v < rows):
            continue
        column, row = int(u), int(v)
        right, down = u - column, v - row
        upper_left = np.uintp(row * width + column)
        lower_left = upper_left + np.uintp(width)
        # Interpolated in steps, so that four equal texels give exactly 0 or 1. A sum of weighted
        # texels would give 1 minus rounding, and the point would count as the edge of a shadow.
        a = 1.0 if texels[upper_left] <= near else 0.0
        b = 1.0 if texels[upper_left + np.uintp(1)] <= near else 0.0
        c = 1.0 if texels[lower_left] <= near else 0.0
        d = 1.0 if texels[lower_left + np.uintp(1)] <= near else 0.0
        upper, lower = a + right * (b - a), c + right * (d - c)
        shares[0, k] = upper + down * (lower - upper)


@inlined
def find_texels(
    view: F64, is_sun: bool, points: Row, nearness: F32, start: int, end: int, texels: F64
) -> None:
    """Find points of a row of the image in a shadow map.

    Args:
        view: (3, 4) view of the map.
        is_sun: True if it is the sun's.
        points: the row.
        nearness: 1/depth of the points of the row [1/m].
        start: first point.
        end: point after the last.
        texels: (3, at least `end`), set to column, row and nearness in the map, from the centre of
            the first texel; columns of −1 for points behind the lamp.
    """
    y, left, step = points
    x_u, x_row, x_near = view[0, 0], view[0, 1] * y + view[0, 2], view[0, 3]
    y_u, y_row, y_near = view[1, 0], view[1, 1] * y + view[1, 2], view[1, 3]
    z_u, z_row, z_near = view[2, 0], view[2, 1] * y + view[2, 2], view[2, 3]
    for j in range(start, end):
        k, x = np.uintp(j), left + j * step
        near = nearness[k]  # all points are scaled by it, which saves divisions
        u, v = x_u * x + x_row + x_near * near, y_u * x + y_row + y_near * near
        w = z_u * x + z_row + z_near * near
        scale = 1.0 / (near if is_sun else w)
        texels[0, k] = u * scale - 0.5 if is_sun or w > 0.0 else -1.0
        texels[1, k] = v * scale - 0.5
        texels[2, k] = w * scale + SUN_BIAS_M if is_sun else (1.0 + LAMP_BIAS) * near * scale


Beam = tuple[float, float, float, float, float, float, float, float, float]


@inlined
def beam_of(beams: F64, k: int) -> Beam:
    """Return row `k` of the beams of `sim.shadows.shadows_and_beams.ShadowsAndBeams`."""
    b = beams[k]
    return b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7], b[8]


@inlined
def beam_lux(
    beam: Beam,
    range_m: float,
    x: float,
    y: float,
    nearness: float,
    normal: tuple[float, float, float],
) -> float:
    """Return the illuminance that a moving lamp's beam gives a surface [lux].

    There is no branch, so that a loop over points can be vectorised.

    Args:
        beam: from `beam_of`.
        range_m: distance at which beams end [m].
        x: position of the surface in the camera's frame, right, over its depth.
        y: position down over its depth.
        nearness: 1 over the depth [1/m].
        normal: unit normal of the surface in the camera's frame: right, down, forward.
    """
    lamp_x, lamp_y, lamp_z, axis_x, axis_y, axis_z, candela, scale, offset = beam
    # From the lamp to the surface, multiplied by the nearness.
    dx, dy, dz = x - nearness * lamp_x, y - nearness * lamp_y, 1.0 - nearness * lamp_z
    along = dx * axis_x + dy * axis_y + dz * axis_z
    across = -(dx * normal[0] + dy * normal[1] + dz * normal[2])
    square = max(dx * dx + dy * dy + dz * dz, MIN_SQUARE)
    inverse = 1.0 / math.sqrt(square)
    square_m2 = square / (nearness * nearness)
    edge = min(max(along * inverse * scale + offset, 0.0), 1.0) if along > 0.0 else 0.0
    fade = square_m2 / (range_m * range_m)
    fade = max(1.0 - fade * fade, 0.0)
    lux: float = candela * edge * edge * fade * fade * max(across, 0.0) * inverse
    return lux / max(square_m2, MIN_SQUARE_M2)
