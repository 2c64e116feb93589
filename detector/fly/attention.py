"""Bottom-up attention: where the fly looks.

All positions are (x, y) in cells; the centre of a cell is at its index. Every response is signed
and computed per axis, so that the view centre moves along both axes.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from detector.errors import StateError
from detector.fly.config import FlyConfig
from detector.fly.correlation import DOWN, LEFT, RIGHT, UP
from detector.fly.model_variants import Attention, LocalMotion
from detector.fly.region import search_square

F32 = npt.NDArray[np.float32]
_NOISE = 0.03
"""Mean activity of saturating surfaces in noise of 10 Hz per pixel, with an `event_gain` of 0.1."""

Pair = tuple[float, float]
"""One value for each axis, x then y."""


def saliency_map(on: F32, off: F32, *, radius: int) -> F32:
    """Return H_on + H_off (inside equation 10), smoothed by a box of side 2·radius + 1 cells.

    Returns:
        (rows, columns) float32; cells outside the grid count as 0.
    """
    side = 2 * radius + 1
    return np.asarray(cv2.blur(on + off, (side, side), borderType=cv2.BORDER_CONSTANT), np.float32)


def most_salient(saliency: F32) -> Pair:
    """Return the position of the saliency maximum, (x, y) in cells (paper, equation 10).

    If several cells share the maximum, it is their mean position. A single active cell, smoothed by
    a box, gives the same maximum in the whole box, and choosing one corner of it would favour a
    direction.
    """
    y, x = np.divmod(np.flatnonzero(saliency == saliency.max()), saliency.shape[1])
    return float(x.mean()), float(y.mean())


def prominence(saliency: F32) -> float:
    """Return the height of the saliency maximum above the mean of the map.

    Uniform noise raises the maximum and the mean alike, however strong it is.
    """
    return float(saliency.max()) - float(saliency.mean(dtype=np.float64))


def position_error(target: Pair, centre: Pair) -> Pair:
    """Return the signed distance from the view centre to the target (paper, equation 11) [cells].

    The two positions of the paper are read as target minus view centre, so that steering by the
    error leads towards the target.
    """
    return target[0] - centre[0], target[1] - centre[1]


def position_response(error: float, *, side: int, cap: float) -> float:
    """Return the signed exponential response 𝒮 to a position error (paper, equation 12).

    Args:
        error: position error on this axis [cells].
        side: K, side of the grid on this axis [cells].
        cap: largest exponent; without it, (4·E/K)² would reach 16 across the grid.
    """
    exponent = min((4.0 * error / side) ** 2, cap)
    return math.copysign(math.expm1(exponent), error)


def local_motion(maps: F32, centre: Pair, *, reach: float) -> Pair:
    """Return the opponent motion ℳ near the view centre over the total (paper, equation 13).

    Args:
        maps: T4 + T5, (4, rows, columns) float32.
        centre: view centre [cells].
        reach: half side of the search square, which is what counts as local [cells].

    Returns:
        ℳ along x (rightward positive) and y (downward positive), each in [−1, 1]; 0 if no cell
        in the square responds.
    """
    rows, columns = search_square(maps.shape[1:], centre, reach=reach)
    sums = maps[:, rows, columns].sum(axis=(1, 2), dtype=np.float64)
    total = float(sums.sum())
    if total == 0.0:
        return 0.0, 0.0
    return float(sums[RIGHT] - sums[LEFT]) / total, float(sums[DOWN] - sums[UP]) / total


def motion_at_centre(maps: F32, centre: Pair) -> Pair:
    """Return the opponent motion ℳ at the cell of the view centre (equation 13 as printed).

    Args:
        maps: T4 + T5, (4, rows, columns) float32.
        centre: view centre [cells].

    Returns:
        ℳ along x (rightward positive) and y (downward positive), not bounded.
    """
    column = min(max(round(centre[0]), 0), maps.shape[2] - 1)
    row = min(max(round(centre[1]), 0), maps.shape[1] - 1)
    right, left, up, down = map(float, maps[:, row, column])
    return right - left, down - up


def steering_response(motion: float, position: float, *, g_m: float, g_p: float) -> float:
    """Fuse the motion and position responses into Γ (paper, equation 14) [cells]."""
    return g_m * motion + g_p * position


def delayed_steering(steering: float, earlier: float, *, alpha: float) -> float:
    """Low-pass Γ while it keeps its sign; otherwise return it unchanged (paper, equation 15).

    Args:
        steering: Γ(t).
        earlier: Γ̂(t − Δt).
        alpha: weight of the new response, in (0, 1).
    """
    if steering * earlier >= 0.0:
        return alpha * steering + (1.0 - alpha) * earlier
    return steering


def shift_towards(error: float, steering: float) -> float:
    """Clip a steering response so that it leads towards the target and not past it [cells]."""
    return min(max(steering, min(error, 0.0)), max(error, 0.0))


class ViewCentre:
    """The point that the fly looks at; the steering response pulls it to the most salient cell.

    It starts at the image centre. If nothing stands out, it returns to the image centre at once,
    forgets its steering, and attends to nothing until something stands out again.

    Attributes:
        position: (x, y) [cells].
        is_attending: True if something stands out.
    """

    def __init__(self, config: FlyConfig, *, grid: tuple[int, int], image_centre: Pair) -> None:
        """Start at the image centre.

        Args:
            config: gains, caps and delays of the steering.
            grid: rows and columns of cells.
            image_centre: (x, y) [cells].
        """
        self._config, self._image_centre = config, image_centre
        self._sides = grid[1], grid[0]
        self.position = image_centre
        self.is_attending = False
        lag = config.window_hops
        self._steered: deque[Pair] = deque([(0.0, 0.0)] * lag, maxlen=lag)

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Return everything that changes, as arrays by name."""
        return {
            "position": np.array(self.position),
            "is_attending": np.array(self.is_attending),
            "steered": np.array(self._steered),
        }

    def check(self, state: dict[str, npt.NDArray[Any]]) -> None:
        """Refuse a state whose position is outside the grid.

        Raises:
            StateError: the position is outside the grid.
        """
        position = state["position"]
        if (np.abs(position - self._image_centre) > np.array(self._sides) / 2).any():
            raise StateError(
                f"The view centre of the state is {position.tolist()}. Allowed are cells of a grid "
                f"of {self._sides[0]} × {self._sides[1]}. Pass everything that "
                "FlyDetector.state() returned, unchanged."
            )

    def restore(self, state: dict[str, npt.NDArray[Any]]) -> None:
        """Continue from a `state` of a view centre with the same configuration and grid."""
        x, y = state["position"].tolist()
        self.position = x, y
        self.is_attending = bool(state["is_attending"])
        self._steered.extend((x, y) for x, y in state["steered"].tolist())

    def release(self) -> None:
        """Return to the image centre and forget the steering."""
        self.position = self._image_centre
        self.is_attending = False
        self._steered.extend([(0.0, 0.0)] * len(self._steered))

    def update(self, saliency: F32, maps: F32, *, activity: float = 0.0) -> None:
        """Move one step towards the most salient cell.

        Args:
            saliency: (rows, columns) float32.
            maps: T4 + T5, (4, rows, columns) float32.
            activity: mean of both surfaces before inhibition, added.
        """
        if self._config.attention is Attention.EVERYWHERE:
            self.is_attending = True
            return
        c = self._config
        if prominence(saliency) < max(c.saliency_floor, c.crowd_share * (activity - _NOISE)):
            self.release()
            return
        self.is_attending = True
        target = most_salient(saliency)
        if self._config.attention is Attention.MAXIMUM:
            self.position = target
            return
        errors = position_error(target, self.position)
        motion = self._motion(maps)
        steered = self._steer(0, errors[0], motion[0]), self._steer(1, errors[1], motion[1])
        self._steered.append(steered)
        self.position = (
            self.position[0] + shift_towards(errors[0], steered[0]),
            self.position[1] + shift_towards(errors[1], steered[1]),
        )

    def _motion(self, maps: F32) -> Pair:
        if self._config.local_motion is LocalMotion.CELL:
            return motion_at_centre(maps, self.position)
        return local_motion(maps, self.position, reach=self._config.roi_reach_cells)

    def _steer(self, axis: int, error: float, motion: float) -> float:
        """Return Γ̂(t) along one axis [cells]."""
        c = self._config
        position = position_response(error, side=self._sides[axis], cap=c.exponent_cap)
        steering = steering_response(motion, position, g_m=c.g_m, g_p=c.g_p)
        return delayed_steering(steering, self._steered[0][axis], alpha=c.alpha)
