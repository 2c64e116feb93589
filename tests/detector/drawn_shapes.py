"""Drawn shapes that move, tilted by any angle, with a given number of events an edge."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from flybench.events import EVENT_DTYPE, Events
from tests.detector.stimuli import HEIGHT, WIDTH, merged, noise, size_before_turning, slide, turned

CONTRAST = 0.9
_SIDE_PX, _SUB = 140, 4
"""Side of the image that a shape is drawn in [px], and sub-pixels per pixel."""


@lru_cache(maxsize=64)
def shape(name: str, tilt_deg: float) -> npt.NDArray[np.float64]:
    """Return the log luminance of a shape of unit contrast, on a background of 0.

    Args:
        name: bar (90×6 px), box, disc, ellipse, triangle or frame.
        tilt_deg: angle by which it is turned clockwise [°].
    """
    y, x = (np.mgrid[: _SIDE_PX * _SUB, : _SIDE_PX * _SUB] + 0.5) / _SUB - _SIDE_PX / 2
    c, s = math.cos(math.radians(tilt_deg)), math.sin(math.radians(tilt_deg))
    u, v = x * c + y * s, y * c - x * s
    inside = {
        "bar": (abs(u) < 3) & (abs(v) < 45),
        "box": (abs(u) < 45) & (abs(v) < 20),
        "disc": np.hypot(u, v) < 25,
        "ellipse": np.hypot(u / 20, v / 35) < 1,
        "triangle": (abs(u) < 25) & (abs(v) < 0.8 * (25 - u)),
        "frame": (np.maximum(abs(u), abs(v)) < 30) & (np.maximum(abs(u), abs(v)) > 22),
    }[name]
    image = inside.reshape(_SIDE_PX, _SUB, _SIDE_PX, _SUB).mean(axis=(1, 3))
    ys, xs = np.nonzero(image)
    return np.ascontiguousarray(image[ys.min() : ys.max() + 1, xs.min() : xs.max() + 1])


@lru_cache(maxsize=64)
def moving_shape(
    name: str,
    direction: Direction,
    *,
    speed_px_s: float,
    tilt_deg: float = 0.0,
    events_per_edge: int = 1,
    noise_hz: float = 0.0,
    seed: int = 0,
) -> tuple[Events, int]:
    """Return the events and duration [µs] of a shape that crosses the middle of the sensor."""
    width, height = size_before_turning(direction)
    image = shape(name, tilt_deg) * CONTRAST
    seconds = min(0.35, (width + image.shape[1]) / speed_px_s)
    duration_us = int(seconds * 1e6)
    rng = np.random.default_rng(seed)
    rightward = slide(
        image,
        speed_px_s=speed_px_s,
        start_px=(width - image.shape[1] - speed_px_s * seconds) / 2 + rng.uniform(-1, 1),
        top_px=(height - image.shape[0]) // 2 + int(rng.integers(-20, 21)),
        duration_us=duration_us,
        background=np.zeros((height, width)),
        threshold=CONTRAST / (events_per_edge + 0.5),
        seed=seed,
    )
    events = turned(rightward, direction, width=width, height=height)
    return merged(events, noise(noise_hz, duration_us=duration_us, seed=seed + 1)), duration_us


def turning_bar(*, rad_s: float = 2.22, seed: int = 0) -> tuple[Events, int, int, int]:
    """Return a bar that turns clockwise, seen above its axis, where it moves to the right.

    Each of its two edges causes one event a pixel.

    Returns:
        Events, duration [µs], width and height of the sensor [px].
    """
    width, height, half_width_px = 185, 65, 4.0
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:height, :width]
    along, across = (
        np.hypot(x - width / 2, height + 30.0 - y),
        np.arctan2(x - width / 2, height + 30.0 - y),
    )
    start, end = -math.radians(38), math.radians(38)
    streams = []
    for polarity, sign in ((True, 1), (False, -1)):
        angle = across - sign * half_width_px / along
        events = np.zeros(x.size, EVENT_DTYPE)
        t_us = (angle - start) / rad_s * 1e6 + rng.uniform(0, 300, angle.shape)
        events["t"], events["x"], events["y"] = t_us.ravel().clip(0), x.ravel(), y.ravel()
        events["p"] = polarity
        is_swept = (angle > start) & (angle < end)
        streams.append(events[is_swept.ravel()])
    duration_us = int((end - start) / rad_s * 1e6)
    events = merged(*streams)
    return events[events["t"] < duration_us], duration_us, width, height


def flickering_scene(*, frequency_hz: float = 100.0, seed: int = 0) -> tuple[Events, int]:
    """Return the events of a still texture under a flickering lamp, and their duration [µs].

    Every half period, the brighter pixels fire with the same polarity, the brightest first.
    """
    duration_us, half_us = 300_000, 0.5e6 / frequency_hz
    rng = np.random.default_rng(seed)
    depth = cv2.GaussianBlur(rng.random((HEIGHT, WIDTH)), (0, 0), 15.0)
    depth = (depth - depth.min()) / np.ptp(depth)
    y, x = np.nonzero(depth > 0.45)
    streams = []
    for n in range(int(duration_us / half_us)):
        fires = rng.random(y.size) < 0.5 * depth[y, x]
        events = np.zeros(int(fires.sum()), EVENT_DTYPE)
        t_us = half_us * (n + 0.4 / (0.5 + depth[y, x])) + rng.uniform(0, 200, y.size)
        events["t"], events["x"], events["y"] = t_us[fires], x[fires], y[fires]
        events["p"] = n % 2 == 0
        streams.append(events)
    events = merged(*streams)
    return events[events["t"] < duration_us], duration_us
