"""Rewards of the events of a window, warped along candidate velocities.

The better the candidate, the fewer pixels the events of an edge cover, and the higher the contrast
of their image; see `detector.contrast_maximisation.warped_image`. A reward is a sum over all pixels
of the image, divided by the number of pixels in a fixed area.
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
"""Number of runs of events whose boxes bound the image (assumed). In windows of 50 ms a run spans
3 ms, in which an object at 1000 px/s moves by 3 px."""


class Reward(IntEnum):
    """A measure of the contrast of the image of warped events, whose pixels are h."""

    VARIANCE = VARIANCE
    """Mean of (h − h̄)² (Gallego and Scaramuzza, 2017)."""
    GRADIENT = GRADIENT
    """Mean of |∇h|², from differences of neighbours (Gallego, Gehrig and Scaramuzza, 2019)."""
    SUPPRESSED = SUPPRESSED
    """Mean of e^(−p·h), the sum of suppressed accumulations: the share of the image that is empty
    (Stoffregen and Kleeman, 2019)."""
    COMBINED = COMBINED
    """Mean of h² times mean of e^(−p·h), the reward R₁ of Stoffregen and Kleeman (2019)."""


def centred_points(
    events: Events, *, most: int, middle_us: float, middle_px: tuple[float, float]
) -> F32:
    """Return x [px], y [px] and the time [s] of each event, from the middle of sensor and window.

    From there, mirrored events have mirrored points, and so do the pixels of their images: with
    pixels of any side, one has its centre in the middle.

    Args:
        events: sorted by t.
        most: largest number of events; from more events, this many are taken, evenly.
        middle_us: middle of the window [µs].
        middle_px: (x, y) of the middle of the sensor [px].

    Returns:
        (3, n) float32.
    """
    points = np.empty((3, min(events.size, most)), np.float32)
    _centre(events, middle_us, middle_px, points)
    return points


@compiled
def _centre(events: Any, middle_us: float, middle_px: Any, points: Any) -> None:
    number = points.shape[1]
    for k in range(number):
        event = events[k * events.size // number]
        points[0, k], points[1, k] = event.x - middle_px[0], event.y - middle_px[1]
        points[2, k] = (event.t - middle_us) * 1e-6


def _boxes(points: F32, number: int) -> F64:
    """Return the least and greatest x, y and t of each run of events, (2, 3, runs).

    A run is a sequence of successive events. It is short, so that the box of a warped run is little
    larger than the run. The size of a candidate's image then follows from the boxes, without a pass
    over the events. There are fewer runs than `number` if there are fewer events.
    """
    events = points.shape[1]
    runs = min(number, events)
    starts = np.arange(runs) * events // max(runs, 1)
    least, greatest = (f.reduceat(points, starts, axis=1) for f in (np.minimum, np.maximum))
    return np.stack([least, greatest]).astype(np.float64)


class WarpedEvents:
    """The events of a window, with reusable memory for their image."""

    def __init__(self, points: F32, *, reward: Reward, area_px: float) -> None:
        """Prepare the events.

        Args:
            points: x [px], y [px] and t [s] from the middle of the window, (3, events) float32;
                fastest if sorted by t.
            reward: measure of contrast.
            area_px: fixed area over which means are taken [px²].
        """
        self._points, self._kind, self._area_px = points, int(reward), area_px
        self._boxes, self._box = _boxes(points, _RUNS), _boxes(points, 1)
        self._buffer = np.zeros(0, np.float32)

    @property
    def number(self) -> int:
        """Number of events."""
        return int(self._points.shape[1])

    def rewards(self, velocities: F64, scale_px: float) -> F64:
        """Return the reward of each candidate velocity.

        Args:
            velocities: candidates, (n, 2), x and y [px/s].
            scale_px: side of an image pixel [px].

        Returns:
            (n,) float64, comparable at one scale only; 0 if there are no events.
        """
        found = np.zeros(len(velocities))
        if self.number:
            buffer, scale = self._buffer_for(velocities, scale_px), self._scale(scale_px)
            rewards_of(self._points, self._boxes, velocities, scale, self._kind, buffer, found)
        return found

    def rewards_by_chance(
        self, velocity: tuple[float, float], scale_px: float, orders: npt.NDArray[np.int32]
    ) -> F64:
        """Return the rewards of a velocity after the events have exchanged their times.

        Args:
            velocity: x and y [px/s].
            scale_px: side of an image pixel [px].
            orders: (n, events) int32; event number i gets the time of event number orders[·, i].

        Returns:
            (n,) float64, one reward per order; 0 if there are no events.
        """
        found = np.zeros(len(orders))
        if self.number:
            buffer, scale = self._buffer_for(np.array([velocity]), scale_px), self._scale(scale_px)
            rewards_by_order(
                self._points, self._box, velocity, orders, scale, self._kind, buffer, found
            )
        return found

    def image(self, velocity: tuple[float, float], scale_px: float = 1.0) -> F32:
        """Return the smoothed image, just large enough for the warped events; needs an event.

        Args:
            velocity: x and y [px/s].
            scale_px: side of an image pixel [px].

        Returns:
            (rows, columns) float32 [events per pixel].
        """
        buffer = self._buffer_for(np.array([velocity]), scale_px)
        image: F32 = smoothed_image(self._points, self._boxes, velocity, 1.0 / scale_px, buffer)
        return image

    def _scale(self, scale_px: float) -> tuple[float, float]:
        """Return the image pixels per sensor pixel along a side, and those in the fixed area."""
        return 1.0 / scale_px, self._area_px / scale_px**2

    def _buffer_for(self, velocities: F64, scale_px: float) -> F32:
        """Return zeroed memory for the image of any candidate; every kernel leaves it zeroed."""
        width_px, height_px, span_s = (self._box[1] - self._box[0]).ravel().tolist()
        vx, vy = np.abs(velocities).max(axis=0).tolist()
        columns = int((width_px + vx * span_s) / scale_px) + 2 * RIM + 3
        rows = int((height_px + vy * span_s) / scale_px) + 2 * RIM + 3
        if columns * rows > self._buffer.size:
            self._buffer = np.zeros(columns * rows, np.float32)
        return self._buffer
