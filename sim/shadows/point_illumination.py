"""Illumination of one point: the share of a light that reaches it, and a beam's illuminance."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import inlined

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

SUN_BIAS_M = 2e-3
"""How much nearer to the sun a caster must be than the point that it shades [m] (assumed)."""
LAMP_BIAS = 1e-4
"""How much nearer to a lamp a caster must be than the point that it shades, relative to the point's
distance from the lamp (assumed)."""


@inlined
def unshadowed_share(
    maps: F32, sizes: I64, is_sun: Bools, shadow: int, u: float, v: float, w: float
) -> float:
    """Return the share of a light, 0 to 1, that passes a moving object and reaches a point.

    Args:
        maps: shadow maps, as in `sim.shadows.shadows_and_beams.ShadowsAndBeams`.
        sizes: rows and columns of each map in use.
        is_sun: True for each map of the sun.
        shadow: index of the shadow.
        u: column of the point in the map; for a lamp, multiplied by `w`.
        v: row of the point in the map; for a lamp, multiplied by `w`.
        w: nearness of the point to the sun, or its distance from a lamp along the map's axis [m].
    """
    if is_sun[shadow]:
        near = w + SUN_BIAS_M
        w = 1.0
    elif w <= 0.0:
        return 1.0
    else:
        near = (1.0 + LAMP_BIAS) / w
    rows, columns = sizes[shadow, 0], sizes[shadow, 1]
    if u < 0.5 * w or v < 0.5 * w or u >= (columns - 1.5) * w or v >= (rows - 1.5) * w:
        return 1.0
    u, v = u / w - 0.5, v / w - 0.5
    column, row = int(u), int(v)
    right, down = u - column, v - row
    # Interpolated in steps, so that four equal texels give exactly 0 or 1. A sum of weighted texels
    # would give 1 minus rounding, and the point would count as the edge of a shadow.
    a = 1.0 if maps[shadow, row, column] <= near else 0.0
    b = 1.0 if maps[shadow, row, column + 1] <= near else 0.0
    c = 1.0 if maps[shadow, row + 1, column] <= near else 0.0
    d = 1.0 if maps[shadow, row + 1, column + 1] <= near else 0.0
    above, below = a + right * (b - a), c + right * (d - c)
    lit: float = above + down * (below - above)
    return lit


@inlined
def beam_lux(
    beams: F64,
    k: int,
    range_m: float,
    x: float,
    y: float,
    z: float,
    normal_x: float,
    normal_y: float,
    normal_z: float,
) -> float:
    """Return the illuminance that a moving lamp's beam gives a surface [lux].

    Args:
        beams: beams, as in `sim.shadows.shadows_and_beams.ShadowsAndBeams`.
        k: index of the beam.
        range_m: distance at which beams end [m].
        x: position of the surface in the camera's frame, right [m].
        y: position, down [m].
        z: position, forward [m].
        normal_x: unit normal of the surface in the camera's frame, right.
        normal_y: unit normal, down.
        normal_z: unit normal, forward.
    """
    dx, dy, dz = x - beams[k, 0], y - beams[k, 1], z - beams[k, 2]
    along = dx * beams[k, 3] + dy * beams[k, 4] + dz * beams[k, 5]
    across = -(dx * normal_x + dy * normal_y + dz * normal_z)
    if along <= 0.0 or across <= 0.0:
        return 0.0
    square = dx * dx + dy * dy + dz * dz
    if (along * beams[k, 7]) ** 2 <= beams[k, 8] * beams[k, 8] * square:
        return 0.0  # outside the cone; no square root needed
    distance = math.sqrt(square)
    edge = along / distance * beams[k, 7] + beams[k, 8]
    if edge <= 0.0:
        return 0.0
    edge = min(edge, 1.0)
    fade = square / (range_m * range_m)
    fade = max(1.0 - fade * fade, 0.0)
    lux: float = beams[k, 6] * edge * edge * fade * fade * across / distance / max(square, 1e-4)
    return lux
