"""What the events of a window are worth, warped along a velocity.

The better the candidate, the fewer pixels the events of an edge share, and the higher the contrast
of their image; see `detector.contrast_maximisation.warped_image`. Rewards are sums over all pixels
there could be, divided by the number of a fixed area.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.contrast_maximisation.warped_image import (
    COMBINED,
    GRADIENT,
    RIM,
    SUPPRESSED,
    VARIANCE,
    rewards_by_order,
    rewards_of,
    smoothed_image,
)
from flybench.events import Events
from flybench.kernels import compiled

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

_RUNS = 16
"""Runs of events whose boxes bound the image (assumed): of 3 ms in windows of 50 ms, in which what
moves by 1000 px/s moves by 3 px."""


class Reward(IntEnum):
    """What the image of warped events, of pixels h, is worth."""

    VARIANCE = VARIANCE
    """Mean of (h − h̄)² (Gallego and Scaramuzza, 2017)."""
    GRADIENT = GRADIENT
    """Mean of |∇h|², by differences of neighbours (Gallego, Gehrig and Scaramuzza, 2019)."""
    SUPPRESSED = SUPPRESSED
    """Mean of e^(−p·h), the sum of suppressed accumulations: how much stays empty (Stoffregen and
    Kleeman, 2019)."""
    COMBINED = COMBINED
    """Mean of h² times mean of e^(−p·h), the reward R₁ of Stoffregen and Kleeman (2019)."""


def centred_points(events: Events, *, most: int, middle_us: float) -> F32:
    """Events as numbers: x [px], y [px] and the time from the window's middle [s].

    Args:
        events: sorted by t.
        most: of more events, so many are taken, evenly.
        middle_us: middle of the window [µs].

    Returns:
        (3, n) float32.
    """
    points = np.empty((3, min(events.size, most)), np.float32)
    _centre(events, middle_us, points)
    return points


@compiled
def _centre(events: Any, middle_us: float, points: Any) -> None:
    number = points.shape[1]
    for k in range(number):
        event = events[k * events.size // number]
        points[0, k], points[1, k] = event.x, event.y
        points[2, k] = (event.t - middle_us) * 1e-6


def _boxes(points: F32, number: int) -> F64:
    """Least and greatest x, y and t of so many runs of events, or of fewer, (2, 3, runs).

    Runs of events in order of time are short, so that the box of a warped run is little larger
    than the run, and no candidate needs a look at every event to know how large its image is.
    """
    events = points.shape[1]
    runs = min(number, events)
    starts = np.arange(runs) * events // max(runs, 1)
    least, greatest = (f.reduceat(points, starts, axis=1) for f in (np.minimum, np.maximum))
    return np.stack([least, greatest]).astype(np.float64)


class WarpedEvents:
    """The events of a window, and the memory for an image of them."""

    def __init__(self, points: F32, *, reward: Reward, area_px: float) -> None:
        """Get ready to warp.

        Args:
            points: x [px], y [px] and t [s] from the middle of the window, (3, events) float32;
                in order of t, for the best speed.
            reward: what counts.
            area_px: fixed area that the means are taken over [px²].
        """
        self._points, self._kind, self._area_px = points, int(reward), area_px
        self._boxes, self._box = _boxes(points, _RUNS), _boxes(points, 1)
        self._room = np.zeros(0, np.float32)

    @property
    def number(self) -> int:
        """How many events there are."""
        return int(self._points.shape[1])

    def rewards(self, velocities: F64, scale_px: float) -> F64:
        """Reward of each candidate velocity.

        Args:
            velocities: candidates, (n, 2), x and y [px/s].
            scale_px: side of the image's pixels [px].

        Returns:
            (n,) float64, to be compared at one scale alone; 0 where there are no events.
        """
        found = np.zeros(len(velocities))
        if self.number:
            room, scale = self._room_for(velocities, scale_px), self._scale(scale_px)
            rewards_of(self._points, self._boxes, velocities, scale, self._kind, room, found)
        return found

    def rewards_by_chance(
        self, velocity: tuple[float, float], scale_px: float, orders: npt.NDArray[np.int32]
    ) -> F64:
        """Reward of a velocity when the events have exchanged their times.

        Args:
            velocity: x and y [px/s].
            scale_px: side of the image's pixels [px].
            orders: (n, events) int32: event number i gets the time of event number orders[·, i].

        Returns:
            (n,) float64; 0 where there are no events.
        """
        found = np.zeros(len(orders))
        if self.number:
            room, scale = self._room_for(np.array([velocity]), scale_px), self._scale(scale_px)
            rewards_by_order(
                self._points, self._box, velocity, orders, scale, self._kind, room, found
            )
        return found

    def image(self, velocity: tuple[float, float], scale_px: float = 1.0) -> F32:
        """The smoothed image itself, as large as it needs to be; of at least an event.

        Args:
            velocity: x and y [px/s].
            scale_px: side of the image's pixels [px].

        Returns:
            (rows, columns) float32 [events a pixel].
        """
        room = self._room_for(np.array([velocity]), scale_px)
        image: F32 = smoothed_image(self._points, self._boxes, velocity, 1.0 / scale_px, room)
        return image

    def _scale(self, scale_px: float) -> tuple[float, float]:
        """Image pixels to a sensor pixel's side, and in the fixed area."""
        return 1.0 / scale_px, self._area_px / scale_px**2

    def _room_for(self, velocities: F64, scale_px: float) -> F32:
        """Memory for an image of any of the candidates; every kernel leaves it empty."""
        width_px, height_px, span_s = (self._box[1] - self._box[0]).ravel().tolist()
        vx, vy = np.abs(velocities).max(axis=0).tolist()
        columns = int((width_px + vx * span_s) / scale_px) + 2 * RIM + 3
        rows = int((height_px + vy * span_s) / scale_px) + 2 * RIM + 3
        if columns * rows > self._room.size:
            self._room = np.zeros(columns * rows, np.float32)
        return self._room
