"""The image of warped events and what it is worth: the kernels of contrast maximisation.

An event at (x, y, t) is moved back along a candidate velocity v to the middle of the window,
x′ = x − v·t, and voted into an image that is then smoothed. The better the candidate, the fewer
pixels the events of an edge share, and the higher the contrast. The image is as large as the
warped events need, so that none is lost and no candidate gains from pushing events out; rewards
are sums over all pixels there could be, divided by the number of a fixed area.
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

_RIM = 4
"""Empty pixels kept around the warped events: a vote spreads by one, and by one more where it is
rounded up; smoothing spreads by one, and leaves out the outermost."""


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
        room = _room(points, velocities, scale_px)
        _rewards(
            points, velocities, 1.0 / scale_px, int(reward), area_px / scale_px**2, room, found
        )
    return found


def warped_image(points: F32, velocity: tuple[float, float], *, scale_px: float = 1.0) -> F32:
    """The image itself, as large as it needs to be; (rows, columns) float32, of at least an event.

    Arguments are those of `rewards`.
    """
    room = _room(points, np.array([velocity]), scale_px)
    image: F32 = _image(points, *velocity, 1.0 / scale_px, room).copy()
    return image


def _room(points: F32, velocities: F64, scale_px: float) -> F32:
    """Memory for an image of any of the candidates, and for one of its rows."""
    reach = np.abs(velocities).max(axis=0) * float(np.abs(points[2]).max())
    columns, rows = (np.ptp(points[:2], axis=1) + 2 * reach) / scale_px + 2 * _RIM + 3
    return np.zeros(int(columns) * (int(rows) + 1), np.float32)


@njit(cache=True, nogil=True)
def _rewards(
    points: Any, velocities: Any, per_px: float, kind: int, pixels: float, room: Any, found: Any
) -> None:
    for n in range(velocities.shape[0]):
        image = _image(points, velocities[n, 0], velocities[n, 1], per_px, room)
        if kind == 0:
            found[n] = _energy(image) / pixels - (points.shape[1] / pixels) ** 2
        elif kind == 1:
            found[n] = _gradient_energy(image) / pixels
        elif kind == 2:
            found[n] = 1.0 - _accumulated(image) / pixels
        else:
            found[n] = (1.0 - _accumulated(image) / pixels) * _energy(image) / pixels


@njit(cache=True, nogil=True)
def _image(points: Any, vx: float, vy: float, per_px: float, room: Any) -> Any:
    """Image of warped events: votes, smoothed."""
    x0, y0, columns, rows = _extent(points, vx * per_px, vy * per_px, per_px)
    image = room[: rows * columns].reshape(rows, columns)
    image[:] = np.float32(0.0)
    _vote(points, vx * per_px, vy * per_px, per_px, x0, y0, image.reshape(-1), columns)
    _smooth(image, room[rows * columns : (rows + 1) * columns])
    return image


@njit(cache=True, nogil=True, fastmath=True)
def _extent(points: Any, ux: float, uy: float, per_px: float) -> Any:
    """Origin, columns and rows of the image; the origin is whole, so that extents do not matter."""
    x, y, t = points[0], points[1], points[2]
    a, bx, by = np.float32(per_px), np.float32(ux), np.float32(uy)
    low_x = high_x = x[0] * a - bx * t[0]
    low_y = high_y = y[0] * a - by * t[0]
    for i in range(1, x.size):
        px, py = x[i] * a - bx * t[i], y[i] * a - by * t[i]
        low_x, high_x = min(low_x, px), max(high_x, px)
        low_y, high_y = min(low_y, py), max(high_y, py)
    x0, y0 = np.floor(low_x) - np.float32(_RIM), np.floor(low_y) - np.float32(_RIM)
    return x0, y0, int(high_x - x0) + _RIM + 1, int(high_y - y0) + _RIM + 1


@njit(cache=True, nogil=True, fastmath=True)
def _vote(
    points: Any, ux: float, uy: float, per_px: float, x0: Any, y0: Any, flat: Any, columns: int
) -> None:
    """Share each event among the nine pixels around it, by a quadratic B-spline along each axis.

    A vote has the variance 1/4 wherever it falls. Bilinear ones have between 0 and 1/4, so that
    contrast would favour velocities that leave events in the middle of pixels: a component of 0
    above all, in place of slow ones.
    """
    x, y, t = points[0], points[1], points[2]
    a, bx, by = np.float32(per_px), np.float32(ux), np.float32(uy)
    half, most = np.float32(0.5), np.float32(0.75)
    for i in range(x.size):
        px, py = x[i] * a - bx * t[i] - x0, y[i] * a - by * t[i] - y0
        column, row = int(px + half), int(py + half)
        fx, fy = px - np.float32(column), py - np.float32(row)
        left, middle, right = (
            half * (half - fx) * (half - fx),
            most - fx * fx,
            half * (half + fx) * (half + fx),
        )
        upper, centre, lower = (
            half * (half - fy) * (half - fy),
            most - fy * fy,
            half * (half + fy) * (half + fy),
        )
        at = (row - 1) * columns + column
        for share in (upper, centre, lower):
            flat[at - 1] += left * share
            flat[at] += middle * share
            flat[at + 1] += right * share
            at += columns


@njit(cache=True, nogil=True, fastmath=True)
def _smooth(image: Any, line: Any) -> None:
    """Blur both axes by the binomial 1 2 1; the rim is empty."""
    rows, columns = image.shape
    half, quarter = np.float32(0.5), np.float32(0.25)
    for r in range(rows):
        here = image[r]
        line[:] = here
        for k in range(1, columns - 1):
            here[k] = half * line[k] + quarter * (line[k - 1] + line[k + 1])
    line[:] = np.float32(0.0)  # from here on the row above as it was, so that one image is enough
    for r in range(rows - 1):
        here, below = image[r], image[r + 1]
        for k in range(columns):
            old = here[k]
            here[k] = half * old + quarter * (line[k] + below[k])
            line[k] = old


@njit(cache=True, nogil=True, fastmath=True)
def _energy(image: Any) -> float:
    """Sum of h²."""
    flat = image.reshape(-1)
    total = 0.0
    for k in range(flat.size):
        total += flat[k] * flat[k]
    return float(total)


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
