"""Event pixels that observe the synthetic scene: compositing of layers, and threshold crossings."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from emulator import SensorConfig
from flybench.events import EVENT_DTYPE, Events
from flybench.kernels import compiled

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

DEFAULT_SENSOR = SensorConfig()
"""Sensor whose thresholds the pixels have; this module uses nothing else of its pixel model."""
EDGE_CONTRAST = 0.8
"""Step of log luminance that `Stimulus.events_per_edge` counts the events of: the contrast of the
base point."""
BASE_EVENTS = 2
"""Number of events for which the pixels have the thresholds of the sensor: those of the default
sensor, 0.28 and 0.35, give two ON and two OFF events of an edge."""
_MIN_THETA = 0.02
"""Lowest threshold of any pixel."""


def threshold_scale(events_per_edge: int) -> float:
    """Return the factor on the thresholds for this many events of an edge of `EDGE_CONTRAST`.

    A threshold of contrast/(events + 1/2) gives that number; the scale is relative to that of the
    base point.
    """
    return (BASE_EVENTS + 0.5) / (events_per_edge + 0.5)


class PixelArray:
    """Pixels with their present log luminance and the level at which each fired last.

    Args:
        background: (height + 2·margin, width + 2·margin) float32, log luminance of the background.
        textures: log luminance of the layers, from back to front, each (rows, columns) float32.
        opacities: opacity of the layers, with the shapes of the textures: 1 hides what is behind.
        margin_px: how far the background extends beyond the image.
        sensor: sensor whose thresholds, with their mismatch, the pixels have.
        scale: factor on these thresholds and their mismatch.
        rng: random generator for the mismatch of the thresholds.
    """

    def __init__(
        self,
        background: F32,
        textures: list[F32],
        opacities: list[F32],
        *,
        margin_px: int,
        sensor: SensorConfig = DEFAULT_SENSOR,
        scale: float = 1.0,
        rng: np.random.Generator,
    ) -> None:
        rows, columns = (size - 2 * margin_px for size in background.shape)
        self._background, self._margin = background, margin_px
        self._layers = [
            (np.ascontiguousarray(texture * opacity), np.ascontiguousarray(opacity))
            for texture, opacity in zip(textures, opacities, strict=True)
        ]
        mismatch = sensor.theta_mismatch
        on, off = (
            np.maximum(
                scale * (theta + mismatch * rng.standard_normal((rows, columns))), _MIN_THETA
            )
            for theta in (sensor.theta_on, sensor.theta_off)
        )
        self._theta_on, self._theta_off = on.astype(np.float32), off.astype(np.float32)
        self._present = np.zeros((rows, columns), np.float32)
        self._level = np.zeros((rows, columns), np.float32)

    def adapt(self, shift_px: F64, corners_px: F64) -> None:
        """Show the first image, to which all pixels adapt without an event.

        Args:
            shift_px: (2,) displacement of the background [px].
            corners_px: (layers, 2) upper left corner of each layer [px].
        """
        self.step(shift_px, corners_px, self._whole, start_us=0.0, step_us=0.0)
        self._level[:] = self._present

    def step(
        self,
        shift_px: F64,
        corners_px: F64,
        region: tuple[int, int, int, int],
        *,
        start_us: float,
        step_us: float,
    ) -> Events:
        """Show the next image; log luminance changes linearly from the previous one.

        Args:
            shift_px: (2,) displacement of the background [px].
            corners_px: (layers, 2) upper left corner of each layer [px].
            region: x0, y0, x1, y1, half-open, where the image may have changed [px].
            start_us: time of the previous image [µs].
            step_us: time since the previous image [µs].

        Returns:
            Events of the step, pixel by pixel, not sorted by time.
        """
        x0, y0, x1, y1 = region
        inside = slice(y0, y1), slice(x0, x1)
        before, level = self._present[inside], self._level[inside]
        now = np.empty_like(before)
        _draw_background(now, self._background, self._margin, x0, y0, shift_px[0], shift_px[1])
        for layer, (x, y) in zip(self._layers, corners_px, strict=True):
            _draw_layer(now, layer[0], layer[1], x - x0, y - y0)
        on, off = self._theta_on[inside], self._theta_off[inside]
        events = np.empty(_count_crossings(now, level, on, off), EVENT_DTYPE)
        _emit_events(events, before, now, level, on, off, x0, y0, start_us, step_us)
        before[:] = now
        return events

    @property
    def _whole(self) -> tuple[int, int, int, int]:
        rows, columns = self._present.shape
        return 0, 0, columns, rows


@compiled
def _draw_background(
    now: Any, image: Any, margin: int, x0: int, y0: int, shift_x: float, shift_y: float
) -> None:
    """Fill a region with the background; each pixel is the mean over its area."""
    rows, columns = now.shape
    left, top = margin + x0 - shift_x, margin + y0 - shift_y
    j, i = int(np.floor(left)), int(np.floor(top))
    right, below = np.float32(left - j), np.float32(top - i)
    one = np.float32(1)
    for y in range(rows):
        for x in range(columns):
            upper = (one - right) * image[i + y, j + x] + right * image[i + y, j + x + 1]
            lower = (one - right) * image[i + y + 1, j + x] + right * image[i + y + 1, j + x + 1]
            now[y, x] = (one - below) * upper + below * lower


@compiled
def _draw_layer(now: Any, texture: Any, opacity: Any, left: float, top: float) -> None:
    """Draw a layer over a region, weighted by the share of each pixel's area that it covers.

    `texture` is multiplied by `opacity` already.
    """
    (rows, columns), (height, width) = now.shape, texture.shape
    j, i = int(np.floor(left)), int(np.floor(top))
    # A pixel overlaps the end of one of the layer's pixels and the start of the next.
    before_x, before_y = np.float32(left - j), np.float32(top - i)
    one = np.float32(1)
    for y in range(max(0, i), min(rows, i + height + 1)):
        for x in range(max(0, j), min(columns, j + width + 1)):
            colour = hidden = np.float32(0)
            for dy in range(2):
                v = y - i - dy
                if v < 0 or v >= height:
                    continue
                share_y = before_y if dy else one - before_y
                for dx in range(2):
                    u = x - j - dx
                    if 0 <= u < width:
                        share = share_y * (before_x if dx else one - before_x)
                        colour += share * texture[v, u]
                        hidden += share * opacity[v, u]
            now[y, x] = colour + (one - hidden) * now[y, x]


@compiled
def _count_crossings(now: Any, level: Any, theta_on: Any, theta_off: Any) -> int:
    """Return the number of thresholds that are crossed on the way to `now`."""
    rows, columns = now.shape
    count = 0
    for y in range(rows):
        for x in range(columns):
            change = now[y, x] - level[y, x]
            theta = theta_on[y, x] if change > 0 else theta_off[y, x]
            count += int(abs(change) / theta)
    return count


@compiled
def _emit_events(
    events: Any,
    before: Any,
    now: Any,
    level: Any,
    theta_on: Any,
    theta_off: Any,
    x0: int,
    y0: int,
    start_us: float,
    step_us: float,
) -> None:
    """Write the events of one step, each at the time at which its threshold is crossed."""
    rows, columns = now.shape
    count = 0
    for y in range(rows):
        for x in range(columns):
            change = now[y, x] - level[y, x]
            theta = theta_on[y, x] if change > 0 else -theta_off[y, x]
            for _ in range(int(abs(change) / abs(theta))):
                level[y, x] += theta
                share = (level[y, x] - before[y, x]) / (now[y, x] - before[y, x])
                event = events[count]
                event.t = int(start_us + min(max(share, 0.0), 1.0) * step_us)
                event.x, event.y, event.p = x0 + x, y0 + y, change > 0
                count += 1
