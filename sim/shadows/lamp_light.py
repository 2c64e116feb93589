"""How much of a lamp's light reaches a place: past a mover's shadow, and in a mover's beam."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import inlined

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

BIAS_M, BIAS = 2e-3, 1e-4
"""How much nearer to its light a caster must be than what it darkens: in parallel light [m], and
relative to the distance from a lamp (assumed)."""


@inlined
def share_let_through(
    maps: F32, sizes: I64, parallel: Bools, shadow: int, u: float, v: float, w: float
) -> float:
    """Share of a light, 0 to 1, that a mover lets through to a point.

    Args:
        maps: as in `sim.shadows.moving_light.Lights`, and so the next two.
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


@inlined
def beam_lux(
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
