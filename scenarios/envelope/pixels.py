"""Pixels that watch the drawn scene: layers painted, thresholds crossed, in compiled code.

Numba notices an edit only in the file of the kernel that Python calls, so all of them live here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from emulator import SensorConfig
from flybench.events import EVENT_DTYPE, Events
from flybench.kernels import compiled

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

_SENSOR = SensorConfig()
THETA_ON, THETA_OFF = _SENSOR.theta_on, _SENSOR.theta_off
THETA_MISMATCH = _SENSOR.theta_mismatch
"""The emulator's thresholds [ln luminance]; nothing else of its pixel is modelled here."""
_LEAST_THETA = 0.02


class Canvas:
    """What the pixels see, and the level at which each fired last.

    Args:
        ground: (height + 2·margin, width + 2·margin) float32, log luminance of the background.
        paints: log luminance of the layers from back to front, each (rows, columns) float32.
        covers: 1 where a layer hides what is behind it, same shapes.
        margin_px: how far the background reaches beyond the image.
        rng: of the thresholds' mismatch.
    """

    def __init__(
        self,
        ground: F32,
        paints: list[F32],
        covers: list[F32],
        *,
        margin_px: int,
        rng: np.random.Generator,
    ) -> None:
        rows, columns = ground.shape[0] - 2 * margin_px, ground.shape[1] - 2 * margin_px
        self._ground, self._margin = ground, margin_px
        self._layers = [
            (np.ascontiguousarray(paint * cover), np.ascontiguousarray(cover))
            for paint, cover in zip(paints, covers, strict=True)
        ]
        on, off = (
            np.maximum(theta + THETA_MISMATCH * rng.standard_normal((rows, columns)), _LEAST_THETA)
            for theta in (THETA_ON, THETA_OFF)
        )
        self._theta_on, self._theta_off = on.astype(np.float32), off.astype(np.float32)
        self._seen = np.zeros((rows, columns), np.float32)
        self._level = np.zeros((rows, columns), np.float32)

    def settle(self, camera_px: F64, corners_px: F64) -> None:
        """Show the first picture: pixels take it as the level that they fired at.

        Args:
            camera_px: (2,) displacement of the background [px].
            corners_px: (layers, 2) upper left corner of each layer [px].
        """
        self.look(camera_px, corners_px, self._whole, start_us=0.0, step_us=0.0)
        self._level[:] = self._seen

    def look(
        self,
        camera_px: F64,
        corners_px: F64,
        region: tuple[int, int, int, int],
        *,
        start_us: float,
        step_us: float,
    ) -> Events:
        """Show the next picture; log luminance goes there in a straight line.

        Args:
            camera_px: as in `settle`.
            corners_px: as in `settle`.
            region: x0, y0, x1, y1, half-open, where anything may have changed [px].
            start_us: time of the picture before [µs].
            step_us: time since then [µs].

        Returns:
            Events of the step, pixel by pixel, not yet sorted by time.
        """
        x0, y0, x1, y1 = region
        inside = slice(y0, y1), slice(x0, x1)
        seen, level = self._seen[inside], self._level[inside]
        now = np.empty_like(seen)
        _paint_ground(now, self._ground, self._margin, x0, y0, camera_px[0], camera_px[1])
        for layer, (x, y) in zip(self._layers, corners_px, strict=True):
            _paint_layer(now, layer[0], layer[1], x - x0, y - y0)
        on, off = self._theta_on[inside], self._theta_off[inside]
        events = np.empty(_count(now, level, on, off), EVENT_DTYPE)
        _fire(events, seen, now, level, on, off, x0, y0, start_us, step_us)
        seen[:] = now
        return events

    @property
    def _whole(self) -> tuple[int, int, int, int]:
        rows, columns = self._seen.shape
        return 0, 0, columns, rows


@compiled
def _paint_ground(
    now: Any, ground: Any, margin: int, x0: int, y0: int, shift_x: float, shift_y: float
) -> None:
    """Fill a region with the background; a pixel is the mean over its area."""
    rows, columns = now.shape
    left, top = margin + x0 - shift_x, margin + y0 - shift_y
    j, i = int(np.floor(left)), int(np.floor(top))
    right, below = np.float32(left - j), np.float32(top - i)
    one = np.float32(1)
    for y in range(rows):
        for x in range(columns):
            upper = (one - right) * ground[i + y, j + x] + right * ground[i + y, j + x + 1]
            lower = (one - right) * ground[i + y + 1, j + x] + right * ground[i + y + 1, j + x + 1]
            now[y, x] = (one - below) * upper + below * lower


@compiled
def _paint_layer(now: Any, paint: Any, cover: Any, left: float, top: float) -> None:
    """Paint a layer over what is there; each pixel takes the share of its area that it covers."""
    (rows, columns), (height, width) = now.shape, paint.shape
    j, i = int(np.floor(left)), int(np.floor(top))
    # A pixel holds the end of the layer's pixel before and the start of the next.
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
                        colour += share * paint[v, u]
                        hidden += share * cover[v, u]
            now[y, x] = colour + (one - hidden) * now[y, x]


@compiled
def _count(now: Any, level: Any, theta_on: Any, theta_off: Any) -> int:
    """How many thresholds are crossed on the way to `now`."""
    rows, columns = now.shape
    count = 0
    for y in range(rows):
        for x in range(columns):
            change = now[y, x] - level[y, x]
            theta = theta_on[y, x] if change > 0 else theta_off[y, x]
            count += int(abs(change) / theta)
    return count


@compiled
def _fire(
    events: Any,
    seen: Any,
    now: Any,
    level: Any,
    theta_on: Any,
    theta_off: Any,
    x0: int,
    y0: int,
    start_us: float,
    step_us: float,
) -> None:
    """Write the events of one step, each at the time when its threshold is crossed."""
    rows, columns = now.shape
    count = 0
    for y in range(rows):
        for x in range(columns):
            change = now[y, x] - level[y, x]
            theta = theta_on[y, x] if change > 0 else -theta_off[y, x]
            for _ in range(int(abs(change) / abs(theta))):
                level[y, x] += theta
                share = (level[y, x] - seen[y, x]) / (now[y, x] - seen[y, x])
                event = events[count]
                event.t = int(start_us + min(max(share, 0.0), 1.0) * step_us)
                event.x, event.y, event.p = x0 + x, y0 + y, change > 0
                count += 1
