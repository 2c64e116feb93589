"""Lobula plate tangential cells: from direction maps to one decision."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from detector.correlation import DOWN, LEFT, RIGHT, UP
from detector.estimate import Direction

_BELOW_ONE = math.nextafter(1.0, 0.0)


def lobula_plate(
    maps: npt.NDArray[np.float32], attended: npt.NDArray[np.bool_]
) -> tuple[float, float, float, float]:
    """Sum of T4 + T5 over the region of interest, by direction (paper, equations 17 and 18).

    A correlation belongs to the region when its pair's midpoint does; see `detector.correlation`.

    Args:
        maps: T4 + T5, (4, rows, columns) float32, planes right, left, up, down.
        attended: 𝒜, True inside the region of interest, (rows, columns).

    Returns:
        LP of right, left, up and down, each ≥ 0.
    """
    right, left, up, down = maps.sum(axis=(1, 2), dtype=np.float64, where=attended)
    return float(right), float(left), float(up), float(down)


def horizontal_system(lp: tuple[float, float, float, float]) -> float:
    """HS: rightward minus leftward (paper, equation 19)."""
    return lp[RIGHT] - lp[LEFT]


def vertical_system(lp: tuple[float, float, float, float]) -> float:
    """VS: downward minus upward (paper, equation 19)."""
    return lp[DOWN] - lp[UP]


def normalise(response: float, *, cells: int, scale: float) -> float:
    """Bring a response into (−1, 1) by a sigmoid (paper, end of section II-D).

    Args:
        response: HS or VS.
        cells: number of cells in the grid.
        scale: response per cell at which the sigmoid's slope has fallen to 0.79 of its first.

    Returns:
        2 / (1 + e^(−response / (cells · scale))) − 1, kept inside the open interval.
    """
    value = math.tanh(response / (2.0 * cells * scale))
    return max(-_BELOW_ONE, min(_BELOW_ONE, value))


def winner_take_all(hs: float, vs: float, *, floor: float) -> Direction:
    """Direction of the stronger system, or none where both stay below the floor.

    A tie goes to the horizontal system.

    Args:
        hs: normalised horizontal response.
        vs: normalised vertical response.
        floor: least strength that counts as motion, in (0, 1).
    """
    if max(abs(hs), abs(vs)) < floor:
        return Direction.NONE
    if abs(hs) >= abs(vs):
        return Direction.RIGHT if hs > 0 else Direction.LEFT
    return Direction.DOWN if vs > 0 else Direction.UP
