"""Lobula plate tangential cells: from direction maps to one decision."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from detector.fly.correlation import DOWN, LEFT, RIGHT, UP
from flybench.direction import Direction

_BELOW_ONE = math.nextafter(1.0, 0.0)


def lobula_plate(
    maps: npt.NDArray[np.float32], attended: npt.NDArray[np.bool_]
) -> tuple[float, float, float, float]:
    """Sum of T4 + T5 over the region of interest, by direction (paper, equations 17 and 18).

    A correlation belongs to the region when its pair's midpoint does; see
    `detector.fly.correlation`.

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


def signal_to_noise(
    maps: npt.NDArray[np.float32], attended: npt.NDArray[np.bool_]
) -> tuple[float, float]:
    """How far HS and VS stand out from what cells that do not agree would give.

    A cell's opponent response is d, rightward minus leftward (or downward minus upward); HS is
    the sum of d over the region. Were the signs of d independent, as noise has them, the standard
    deviation of that sum would be √Σd²: the ratio is the response in units of it. It needs no
    scale, so one floor serves by day and by night and in any noise: few cells cannot reach it,
    however active they are, nor can many that disagree.

    Args:
        maps: T4 + T5, (4, rows, columns) float32, planes right, left, up, down.
        attended: 𝒜, True inside the region of interest, (rows, columns).

    Returns:
        The ratio of HS and of VS, each ≥ 0 and at most the square root of the number of cells;
        0 in suppress_output.
    """
    cells = np.flatnonzero(attended)
    right, left, up, down = maps.reshape(4, -1)[:, cells].astype(np.float64)
    return _ratio(right - left), _ratio(down - up)


def _ratio(opponent: npt.NDArray[np.float64]) -> float:
    power = float(opponent @ opponent)
    return abs(float(opponent.sum())) / math.sqrt(power) if power > 0.0 else 0.0


def normalise(response: float, *, cells: int, scale: float) -> float:
    """Bring a response into (−1, 1) by a sigmoid (paper, end of section II-D).

    Args:
        response: HS or VS.
        cells: number of cells in the grid.
        scale: response per cell at which the sigmoid's slope has fallen to 0.79 of its first.

    Returns:
        2 / (1 + e^(−response / (cells · scale))) − 1, kept inside the open interval.
    """
    return within_one(math.tanh(response / (2.0 * cells * scale)))


def shares_of_total(lp: tuple[float, float, float, float]) -> tuple[float, float]:
    """HS and VS as shares of what they are the difference of, each in (−1, 1).

    Args:
        lp: LP of right, left, up and down; see `lobula_plate`.
    """
    return (
        _share(horizontal_system(lp), lp[RIGHT] + lp[LEFT]),
        _share(vertical_system(lp), lp[UP] + lp[DOWN]),
    )


def _share(response: float, total: float) -> float:
    return within_one(response / total) if total > 0.0 else 0.0


def within_one(value: float) -> float:
    """The value, kept within (−1, 1)."""
    return max(-_BELOW_ONE, min(_BELOW_ONE, value))


def winner_take_all(
    hs: float,
    vs: float,
    *,
    snr: tuple[float, float],
    snr_floor: float,
    shares: tuple[float, float] = (1.0, 1.0),
    share_floor: float = 0.0,
) -> Direction:
    """Direction of the stronger system, or none where it does not stand out.

    A tie goes to the horizontal system.

    Args:
        hs: normalised horizontal response.
        vs: normalised vertical response.
        snr: signal-to-noise ratio of either; see `signal_to_noise`.
        snr_floor: least ratio that counts as motion.
        shares: either as a share of both directions' sum; see `shares_of_total`.
        share_floor: least share, of either sign, that counts as motion.
    """
    is_horizontal = abs(hs) >= abs(vs)
    response, ratio = (hs, snr[0]) if is_horizontal else (vs, snr[1])
    share = abs(shares[0] if is_horizontal else shares[1])
    if response == 0.0 or ratio < snr_floor or share < share_floor:
        return Direction.NONE
    if is_horizontal:
        return Direction.RIGHT if response > 0 else Direction.LEFT
    return Direction.DOWN if response > 0 else Direction.UP
