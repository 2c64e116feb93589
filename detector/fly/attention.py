"""Bottom-up attention: where the fly looks.

All positions here are in cells, (x, y), with a cell's centre at its index. Every response is kept
signed and per axis, so that the view centre moves along both.
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
Pair = tuple[float, float]
"""One value for each axis, x then y."""


def saliency_map(on: F32, off: F32, *, radius: int) -> F32:
    """H_on + H_off (inside equation 10), smoothed by a box of side 2·radius + 1 cells.

    Returns:
        (rows, columns) float32; outside the grid counts as 0.
    """
    side = 2 * radius + 1
    return np.asarray(cv2.blur(on + off, (side, side), borderType=cv2.BORDER_CONSTANT), np.float32)


def most_salient(saliency: F32) -> Pair:
    """Position of the maximum, (x, y) in cells (paper, equation 10).

    Among equals it is their middle: a lone spot, smoothed by a box, has its maximum all over the
    box, and any one corner of it would favour a direction.
    """
    y, x = np.nonzero(saliency == saliency.max())
    return float(x.mean()), float(y.mean())


def prominence(saliency: F32) -> float:
    """How far the most salient cell stands out from the mean of the map.

    Noise that is everywhere raises both alike, however strong it is.
    """
    return float(saliency.max()) - float(saliency.mean(dtype=np.float64))


def position_error(target: Pair, centre: Pair) -> Pair:
    """Signed way from the view centre to the target on each axis (paper, equation 11) [cells].

    The paper's two positions are read as target minus view centre, so that steering by the error
    leads towards the target.
    """
    return target[0] - centre[0], target[1] - centre[1]


def position_response(error: float, *, side: int, cap: float) -> float:
    """Signed exponential response 𝒮 to a position error (paper, equation 12).

    Args:
        error: position error on this axis [cells].
        side: K, the grid's side on this axis [cells].
        cap: largest exponent; (4·E/K)² would reach 16 across the grid.
    """
    exponent = min((4.0 * error / side) ** 2, cap)
    return math.copysign(math.expm1(exponent), error)


def local_motion(maps: F32, centre: Pair, *, reach: float) -> Pair:
    """Opponent motion ℳ around the view centre over the total (paper, equation 13).

    Args:
        maps: T4 + T5, (4, rows, columns) float32.
        centre: view centre [cells].
        reach: half side of the square that counts as local, the search square [cells].

    Returns:
        ℳ along x (rightward positive) and y (downward positive), each in [−1, 1]; 0 in
        suppress_output.
    """
    rows, columns = search_square(maps.shape[1:], centre, reach=reach)
    sums = maps[:, rows, columns].sum(axis=(1, 2), dtype=np.float64)
    total = float(sums.sum())
    if total == 0.0:
        return 0.0, 0.0
    return float(sums[RIGHT] - sums[LEFT]) / total, float(sums[DOWN] - sums[UP]) / total


def motion_at_centre(maps: F32, centre: Pair) -> Pair:
    """Opponent motion ℳ at the cell of the view centre (paper, equation 13 as printed).

    Args:
        maps: T4 + T5, (4, rows, columns) float32.
        centre: view centre [cells].

    Returns:
        ℳ along x (rightward positive) and y (downward positive), of any size.
    """
    column = min(max(round(centre[0]), 0), maps.shape[2] - 1)
    row = min(max(round(centre[1]), 0), maps.shape[1] - 1)
    right, left, up, down = map(float, maps[:, row, column])
    return right - left, down - up


def steering_response(motion: float, position: float, *, g_m: float, g_p: float) -> float:
    """Fuse motion and position response into Γ (paper, equation 14) [cells]."""
    return g_m * motion + g_p * position


def delayed_steering(steering: float, earlier: float, *, alpha: float) -> float:
    """Low-pass Γ while it keeps its sign, else let it through (paper, equation 15).

    Args:
        steering: Γ(t).
        earlier: Γ̂(t − Δt).
        alpha: share of the new response, in (0, 1).
    """
    if steering * earlier >= 0.0:
        return alpha * steering + (1.0 - alpha) * earlier
    return steering


def shift_towards(error: float, steering: float) -> float:
    """Part of a steering response that leads towards the target and not beyond it [cells]."""
    return min(max(steering, min(error, 0.0)), max(error, 0.0))


class ViewCentre:
    """Where the fly looks: pulled to the most salient cell by the steering response.

    It starts at the image centre. When nothing stands out it lets go: it returns to the image
    centre at once, forgets its steering, and attends to nothing until something stands out again.

    Attributes:
        position: (x, y) [cells].
        is_attending: whether something is salient.
    """

    def __init__(self, config: FlyConfig, *, grid: tuple[int, int], home: Pair) -> None:
        """Rest at the image centre.

        Args:
            config: gains, caps and delays of the steering.
            grid: rows and columns of cells.
            home: image centre [cells].
        """
        self._config, self._home = config, home
        self._sides = grid[1], grid[0]
        self.position = home
        self.is_attending = False
        lag = config.window_hops
        self._steered: deque[Pair] = deque([(0.0, 0.0)] * lag, maxlen=lag)

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Everything that changes, as arrays by name."""
        return {
            "position": np.array(self.position),
            "is_attending": np.array(self.is_attending),
            "steered": np.array(self._steered),
        }

    def check(self, state: dict[str, npt.NDArray[Any]]) -> None:
        """Refuse a state that looks beside the grid.

        Raises:
            StateError: it does.
        """
        position = state["position"]
        if (np.abs(position - self._home) > np.array(self._sides) / 2).any():
            raise StateError(
                f"the state looks at {position.tolist()}; allowed are cells of a grid of "
                f"{self._sides[0]} × {self._sides[1]}; pass what FlyDetector.state() gave, whole"
            )

    def restore(self, state: dict[str, npt.NDArray[Any]]) -> None:
        """Go on from what `state` of the same configuration and grid gave."""
        x, y = state["position"].tolist()
        self.position = x, y
        self.is_attending = bool(state["is_attending"])
        self._steered.extend((x, y) for x, y in state["steered"].tolist())

    def release(self) -> None:
        """Let go: back to the image centre, steering forgotten."""
        self.position = self._home
        self.is_attending = False
        self._steered.extend([(0.0, 0.0)] * len(self._steered))

    def update(self, saliency: F32, maps: F32) -> None:
        """Take one step towards the most salient cell.

        Args:
            saliency: (rows, columns) float32.
            maps: T4 + T5, (4, rows, columns) float32.
        """
        if self._config.attention is Attention.EVERYWHERE:
            self.is_attending = True
            return
        if prominence(saliency) < self._config.saliency_floor:
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
        """Γ̂(t) along one axis [cells]."""
        c = self._config
        position = position_response(error, side=self._sides[axis], cap=c.exponent_cap)
        steering = steering_response(motion, position, g_m=c.g_m, g_p=c.g_p)
        return delayed_steering(steering, self._steered[0][axis], alpha=c.alpha)
