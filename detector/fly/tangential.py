"""Lobula plate tangential cells: from direction maps to the responses of HS and VS.

Direction maps are the planes right, left, up and down of T4 + T5, (4, rows, columns) float32.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.decision import clip_to_open_interval, sum_to_noise
from detector.errors import StateError
from detector.fly.correlation import DOWN, LEFT, RIGHT, UP

DirectionSums = tuple[float, float, float, float]
"""LP of right, left, up and down."""
_SILENCE: DirectionSums = (0.0, 0.0, 0.0, 0.0)


def lobula_plate(maps: npt.NDArray[np.float32], attended: npt.NDArray[np.bool_]) -> DirectionSums:
    """Sum T4 + T5 over the region of interest, by direction (paper, equations 17 and 18).

    A correlation belongs to the region if the midpoint of its pair does; see
    `detector.fly.correlation`.

    Args:
        maps: direction maps, (4, rows, columns) float32.
        attended: 𝒜, True inside the region of interest, (rows, columns).

    Returns:
        LP of right, left, up and down, each ≥ 0.
    """
    right, left, up, down = maps.sum(axis=(1, 2), dtype=np.float64, where=attended)
    return float(right), float(left), float(up), float(down)


class LeakyIntegrator:
    """Low-pass of the sums over the region, as a membrane has it."""

    def __init__(self, *, time_constant_us: int, hop_us: int) -> None:
        """Start at rest.

        Args:
            time_constant_us: time constant [µs]; 0: none, the sums stay as they are.
            hop_us: step between estimates [µs].
        """
        self._gain = -math.expm1(-hop_us / time_constant_us) if time_constant_us else 1.0
        self._sums: DirectionSums = _SILENCE

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Return everything that changes, as arrays by name."""
        return {"sums": np.array(self._sums)}

    def check(self, state: dict[str, npt.NDArray[Any]]) -> None:
        """Refuse a state that no integrator returns.

        Raises:
            StateError: a sum is negative.
        """
        if (state["sums"] < 0.0).any():
            raise StateError(
                f"The sums of the state are {state['sums'].tolist()}. Allowed are 0 or more. Pass "
                "everything that FlyDetector.state() returned, unchanged."
            )

    def restore(self, state: dict[str, npt.NDArray[Any]]) -> None:
        """Continue from a `state` of an integrator with the same configuration."""
        right, left, up, down = state["sums"].tolist()
        self._sums = right, left, up, down

    def rest(self) -> None:
        """Return to the initial state."""
        self._sums = _SILENCE

    def __call__(self, lp: DirectionSums) -> DirectionSums:
        """Return the low-pass of the sums up to now; at rest again if nothing responds.

        Args:
            lp: LP of right, left, up and down; see `lobula_plate`.
        """
        if not any(lp):
            self.rest()
            return self._sums
        right, left, up, down = (
            before + self._gain * (now - before) for before, now in zip(self._sums, lp, strict=True)
        )
        self._sums = right, left, up, down
        return self._sums


def horizontal_system(lp: DirectionSums) -> float:
    """Return HS, rightward minus leftward (paper, equation 19)."""
    return lp[RIGHT] - lp[LEFT]


def vertical_system(lp: DirectionSums) -> float:
    """Return VS, downward minus upward (paper, equation 19)."""
    return lp[DOWN] - lp[UP]


def signal_to_noise(
    maps: npt.NDArray[np.float32], attended: npt.NDArray[np.bool_]
) -> tuple[float, float]:
    """Return the ratios of HS and VS to what cells of random sign would give.

    Let d be the opponent response of a cell: rightward minus leftward, or downward minus upward.
    HS or VS is the sum of d over the region. If the signs of d were independent, as in noise, the
    standard deviation of that sum would be √Σd². The ratio is |Σd| / √Σd², the response in standard
    deviations. It needs no scale, so one floor serves day, night and any noise. Few cells cannot
    reach it however active they are, nor can many cells that disagree.

    Args:
        maps: direction maps, (4, rows, columns) float32.
        attended: 𝒜, True inside the region of interest, (rows, columns).

    Returns:
        The ratios of HS and VS, each ≥ 0 and at most the square root of the number of cells; 0 if
        no cell responds.
    """
    cells = np.flatnonzero(attended)
    right, left, up, down = maps.reshape(4, -1)[:, cells].astype(np.float64)
    return sum_to_noise(right - left), sum_to_noise(down - up)


def normalise(response: float, *, cells: int, scale: float) -> float:
    """Map a response into (−1, 1) by a sigmoid (paper, end of section II-D).

    Args:
        response: HS or VS.
        cells: number of cells in the grid.
        scale: response per cell at which the slope of the sigmoid has fallen to 0.79 of its value
            at 0.

    Returns:
        2 / (1 + e^(−response / (cells · scale))) − 1, clipped to the open interval.
    """
    return clip_to_open_interval(math.tanh(response / (2.0 * cells * scale)))


def shares_of_total(lp: DirectionSums) -> tuple[float, float]:
    """Return HS and VS relative to the sum of their two directions, each in (−1, 1).

    Args:
        lp: LP of right, left, up and down; see `lobula_plate`.
    """
    return (
        _share(horizontal_system(lp), lp[RIGHT] + lp[LEFT]),
        _share(vertical_system(lp), lp[UP] + lp[DOWN]),
    )


def shares_of_all(lp: DirectionSums) -> tuple[float, float]:
    """Return HS and VS relative to the sum of all four directions, each in (−1, 1).

    This is divisive normalisation by the total activity: the ratio of HS and VS stays as it is, and
    neither depends on the number of events.

    Args:
        lp: LP of right, left, up and down; see `lobula_plate`.
    """
    total = sum(lp)
    return _share(horizontal_system(lp), total), _share(vertical_system(lp), total)


def _share(response: float, total: float) -> float:
    return clip_to_open_interval(response / total) if total > 0.0 else 0.0
