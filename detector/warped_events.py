"""The image of warped events and what it is worth: the kernels of contrast maximisation.

An event at (x, y, t) is moved back along a candidate velocity v to the middle of the window,
x′ = x − v·t, and voted into an image. The better the candidate, the fewer pixels the events of an
edge share, and the higher the contrast. The image is as large as the warped events need, so that
none is lost and no candidate gains from pushing events out; rewards are sums over all pixels
there could be, divided by the number of a fixed area.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]


class Reward(IntEnum):
    """What the image of warped events, of pixels h, is worth."""

    VARIANCE = 0
    """Mean of (h − h̄)² (Gallego and Scaramuzza, 2017)."""
    GRADIENT = 1
    """Mean of |∇h|², by differences of neighbours (Gallego, Gehrig and Scaramuzza, 2019)."""
    SUPPRESSED = 2
    """Mean of e^(−p·h), the sum of suppressed accumulations: how much stays empty (Stoffregen and
    Kleeman, 2019)."""
    COMBINED = 3
    """Mean of h² times mean of e^(−p·h), the reward R₁ of Stoffregen and Kleeman (2019)."""


SUPPRESSION = 3.0
"""p of the suppressed accumulations; the value of Stoffregen's published code."""

_RIM = 2
"""Empty pixels kept around the warped events; a vote spreads by one."""


def rewards(
    points: F32, velocities: F64, *, scale_px: float, reward: Reward, area_px: float
) -> F64:
    """Reward of each candidate velocity.

    Args:
        points: x [px], y [px] and t [s] from the middle of the window, (3, events) float32.
        velocities: candidates, (n, 2), x and y [px/s].
        scale_px: side of the image's pixels [px].
        reward: which.
        area_px: fixed area that the means are taken over [px²].

    Returns:
        (n,) float64, to be compared at one scale alone.
    """
    found = np.zeros(len(velocities))
    if points.shape[1]:
        reach = np.abs(velocities).max(axis=0) * float(np.abs(points[2]).max())
        spans = (np.ptp(points[:2], axis=1) + 2 * reach) / scale_px + 2 * _RIM + 2
        room = np.zeros(int(spans[0] + 1) * int(spans[1] + 1), np.float32)
        pixels = area_px / scale_px**2
        _rewards(points, velocities, 1.0 / scale_px, int(reward), pixels, room, found)
    return found


def warped_image(points: F32, velocity: tuple[float, float], *, scale_px: float = 1.0) -> F32:
    """The image itself, for display and tests; (rows, columns) float32, its origin unspecified."""
    vx, vy = velocity
    reach = np.abs(velocity) * float(np.abs(points[2]).max(initial=0.0))
    spans = (np.ptp(points[:2], axis=1) + 2 * reach) / scale_px + 2 * _RIM + 2
    room = np.zeros(int(spans[0] + 1) * int(spans[1] + 1), np.float32)
    image, _ = _vote(points, vx, vy, 1.0 / scale_px, room)
    return np.array(image)


@njit(cache=True, nogil=True)
def _rewards(
    points: Any, velocities: Any, per_px: float, kind: int, pixels: float, room: Any, found: Any
) -> None:
    mean = points.shape[1] / pixels
    for n in range(velocities.shape[0]):
        image, squares = _vote(points, velocities[n, 0], velocities[n, 1], per_px, room)
        if kind == 0:
            found[n] = squares / pixels - mean * mean
        elif kind == 1:
            found[n] = _gradient_energy(image) / pixels
        else:
            empty = 1.0 - _accumulated(image) / pixels
            found[n] = empty if kind == 2 else empty * squares / pixels


@njit(cache=True, nogil=True, fastmath=True)
def _vote(points: Any, vx: float, vy: float, per_px: float, room: Any) -> Any:
    """Image of warped events by bilinear votes, and Σ h², which grows with every vote."""
    x, y, t = points[0], points[1], points[2]
    one = np.float32(1.0)
    share, ux, uy = np.float32(per_px), np.float32(vx * per_px), np.float32(vy * per_px)
    low_x = high_x = x[0] * share - ux * t[0]
    low_y = high_y = y[0] * share - uy * t[0]
    for i in range(1, x.size):
        px, py = x[i] * share - ux * t[i], y[i] * share - uy * t[i]
        low_x, high_x = min(low_x, px), max(high_x, px)
        low_y, high_y = min(low_y, py), max(high_y, py)
    # Cuts at whole pixels, so that the image's place does not depend on its extent.
    x0, y0 = np.floor(low_x) - np.float32(_RIM), np.floor(low_y) - np.float32(_RIM)
    columns, rows = int(high_x - x0) + _RIM + 1, int(high_y - y0) + _RIM + 1
    image = room[: rows * columns]
    image[:] = np.float32(0.0)
    squares = 0.0
    for i in range(x.size):
        px, py = x[i] * share - ux * t[i] - x0, y[i] * share - uy * t[i] - y0
        column, row = int(px), int(py)
        fx, fy = px - np.float32(column), py - np.float32(row)
        at = row * columns + column
        for k, w in (
            (at, (one - fx) * (one - fy)),
            (at + 1, fx * (one - fy)),
            (at + columns, (one - fx) * fy),
            (at + columns + 1, fx * fy),
        ):
            h = image[k]
            squares += w * (h + h + w)
            image[k] = h + w
    return image.reshape(rows, columns), squares


@njit(cache=True, nogil=True, fastmath=True)
def _gradient_energy(image: Any) -> float:
    """Sum of |∇h|² by differences of neighbours."""
    rows, columns = image.shape
    total = 0.0
    for r in range(rows - 1):
        here, below = image[r], image[r + 1]
        for c in range(columns - 1):
            across, down = here[c + 1] - here[c], below[c] - here[c]
            total += across * across + down * down
    return float(total)


@njit(cache=True, nogil=True)
def _accumulated(image: Any) -> float:
    """Sum of 1 − e^(−p·h), to which empty pixels add nothing."""
    total = 0.0
    flat = image.reshape(-1)
    for k in range(flat.size):
        if flat[k] > 0.0:
            total += 1.0 - np.exp(-SUPPRESSION * flat[k])
    return total
