"""The image of warped events and what it is worth: the kernels of contrast maximisation.

An event at (x, y, t) is moved back along a candidate velocity v to the middle of the window,
x′ = x − v·t, and voted into an image that is then smoothed by a Gaussian of one pixel. Without
that, votes would favour velocities that put many events on the middle of pixels, and rest most of
all. The better the candidate, the fewer pixels the events of an
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

_RIM = 5
"""Empty pixels kept around the warped events: a vote spreads by one, smoothing by two, and two
more are the border of the smoothing."""


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
        _rewards(points, velocities, 1.0 / scale_px, int(reward), area_px / scale_px**2, room, found)
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
    """Image of warped events: bilinear votes, smoothed."""
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
    """Share each event among the four pixels around it."""
    x, y, t = points[0], points[1], points[2]
    a, bx, by, one = np.float32(per_px), np.float32(ux), np.float32(uy), np.float32(1.0)
    for i in range(x.size):
        px, py = x[i] * a - bx * t[i] - x0, y[i] * a - by * t[i] - y0
        column, row = int(px), int(py)
        fx, fy = px - np.float32(column), py - np.float32(row)
        at = row * columns + column
        flat[at] += (one - fx) * (one - fy)
        flat[at + 1] += fx * (one - fy)
        flat[at + columns] += (one - fx) * fy
        flat[at + columns + 1] += fx * fy


@njit(cache=True, nogil=True, fastmath=True)
def _smooth(image: Any, line: Any) -> None:
    """Blur both axes by the binomial 1 4 6 4 1, a Gaussian of σ = 1 pixel; the rim is empty."""
    rows, columns = image.shape
    b, c, d = np.float32(1 / 16), np.float32(4 / 16), np.float32(6 / 16)
    for r in range(rows):
        here = image[r]
        line[:] = here
        for k in range(2, columns - 2):
            near, far = line[k - 1] + line[k + 1], line[k - 2] + line[k + 2]
            here[k] = d * line[k] + c * near + b * far
    # Downwards with the two rows above kept, so that one image is enough.
    above, above2 = np.zeros(columns, np.float32), np.zeros(columns, np.float32)
    for r in range(rows - 2):
        here, below, below2 = image[r], image[r + 1], image[r + 2]
        for k in range(columns):
            old = here[k]
            here[k] = d * old + c * (above[k] + below[k]) + b * (above2[k] + below2[k])
            above2[k] = above[k]
            above[k] = old


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
