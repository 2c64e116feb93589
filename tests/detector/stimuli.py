"""Synthetic stimuli: events of patterns that slide over an ideal sensor.

A pattern is an image of log luminance, NaN where it is transparent, that moves to the right at
constant speed in front of a background. Each pixel averages over its width and fires whenever its
log luminance has changed by a contrast threshold. `turned` gives the other three directions.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from flybench.events import EVENT_DTYPE, Events

WIDTH, HEIGHT = 346, 260
THRESHOLD = 0.2
STEP_PX = 0.5

F64 = npt.NDArray[np.float64]


def car(length_px: int = 200, height_px: int = 60, *, contrast: float = 1.0) -> F64:
    """Return a sedan from the side, with its shadow, for a road of log luminance 0."""
    image: F64 = np.full((height_px + 6, length_px), np.nan)
    roof, belt, sill = 0, int(0.38 * height_px), int(0.85 * height_px)
    image[belt:sill] = 0.5
    x = np.arange(length_px)
    cabin = (x > 0.22 * length_px) & (x < 0.80 * length_px)
    image[roof:belt, cabin] = 0.5
    for start, end in ((0.26, 0.50), (0.53, 0.76)):
        image[roof + 4 : belt, int(start * length_px) : int(end * length_px)] = -0.9
    image[belt:sill, [int(s * length_px) for s in (0.28, 0.515, 0.72)]] = -0.2
    image[belt + 4 : belt + 10, -8:] = 1.2
    image[belt + 4 : belt + 10, :6] = -0.4
    image[sill:height_px, 4:-4] = -0.7
    image[height_px:] = -1.1
    y = np.arange(height_px + 6)[:, None]
    for hub in (0.19, 0.80):
        distance = np.hypot(x - hub * length_px, y - 0.82 * height_px) / (0.18 * height_px)
        image[distance < 1.0] = -1.2
        image[distance < 0.55] = 0.3
    return np.asarray(image * contrast, np.float64)


def textured_box(length_px: int = 120, height_px: int = 50, *, seed: int = 0) -> F64:
    """Return a rectangle of random patches of 6×6 px, ±0.5 in log luminance."""
    rng = np.random.default_rng(seed)
    patches = rng.uniform(-0.5, 0.5, (-(-height_px // 6), -(-length_px // 6)))
    return np.asarray(np.kron(patches, np.ones((6, 6)))[:height_px, :length_px], np.float64)


def plain_box(length_px: int = 120, height_px: int = 50, *, level: float = 0.8) -> F64:
    """Return a rectangle without texture."""
    return np.full((height_px, length_px), level)


def asphalt(height_px: int, width_px: int, *, seed: int = 1) -> F64:
    """Return a background of fine and coarse grain, ±0.2 in log luminance, with a lane mark."""
    rng = np.random.default_rng(seed)
    coarse = np.kron(rng.normal(0, 0.1, (-(-height_px // 8), -(-width_px // 8))), np.ones((8, 8)))
    image = coarse[:height_px, :width_px] + rng.normal(0, 0.06, (height_px, width_px))
    image[int(0.72 * height_px) : int(0.74 * height_px)] += 0.8
    return image


def slide(
    pattern: F64,
    *,
    speed_px_s: float,
    start_px: float,
    top_px: int,
    duration_us: int,
    background: F64,
    threshold: float = THRESHOLD,
    seed: int = 0,
) -> Events:
    """Return events of a pattern whose left edge moves from `start_px` to the right.

    Args:
        pattern: (rows, columns) log luminance, NaN where transparent.
        speed_px_s: image speed [px/s].
        start_px: position of the left edge at time 0 [px].
        top_px: position of the upper edge [px].
        duration_us: duration of the motion [µs].
        background: log luminance of the whole image.
        threshold: mean contrast threshold; its standard deviation is 4 %.
        seed: seed of the threshold mismatch and of a latency of 0 to 0.3 ms.
    """
    rng = np.random.default_rng(seed)
    rows, columns = pattern.shape
    region = slice(top_px, top_px + rows)
    below = background[region]
    width = below.shape[1]
    opacity = np.pad((~np.isnan(pattern)).astype(float), ((0, 0), (width + 2, width + 2)))
    values = np.pad(np.nan_to_num(pattern), ((0, 0), (width + 2, width + 2)))
    theta = threshold * (1.0 + 0.04 * rng.standard_normal(below.shape))
    level = below.copy()
    step_us = STEP_PX / speed_px_s * 1e6
    parts: list[Events] = []
    for n in range(int(duration_us / step_us)):
        left = start_px + (n + 1) * STEP_PX
        whole = int(np.floor(left))
        share = left - whole
        first, last = max(whole - 1, 0), min(whole + columns + 2, width)
        if first >= last:
            continue
        at = width + 2 - whole
        here, before = slice(first + at, last + at), slice(first + at - 1, last + at - 1)
        cover = (1 - share) * opacity[:, here] + share * opacity[:, before]
        value = (1 - share) * values[:, here] + share * values[:, before]
        log_luminance = value + (1 - cover) * below[:, first:last]
        parts.append(
            _fire(
                log_luminance, level[:, first:last], theta[:, first:last], n * step_us, step_us, rng
            )
        )
        parts[-1]["x"] += first
    events = np.concatenate(parts)
    events = events[events["t"] < duration_us]
    events["y"] += top_px
    return events[np.argsort(events["t"], kind="stable")]


def _fire(
    log_luminance: F64,
    level: F64,
    theta: F64,
    start_us: float,
    step_us: float,
    rng: np.random.Generator,
) -> Events:
    change = (log_luminance - level) / theta
    number = np.trunc(change).astype(int)
    level += number * theta
    ys, xs = np.nonzero(number)
    repeats = np.abs(number[ys, xs])
    which = np.repeat(np.arange(ys.size), repeats)
    rank = np.arange(which.size) - np.repeat(np.cumsum(repeats) - repeats, repeats) + 1
    events = np.zeros(which.size, EVENT_DTYPE)
    moment = rank / np.abs(change[ys, xs])[which]
    latency = rng.uniform(0, 300, ys.size)[which]
    events["t"] = start_us + moment * step_us + latency
    events["x"], events["y"] = xs[which], ys[which]
    events["p"] = number[ys, xs][which] > 0
    return events


def noise(
    rate_hz: float, *, duration_us: int, seed: int = 0, width: int = WIDTH, height: int = HEIGHT
) -> Events:
    """Return Poisson events of random polarity at `rate_hz` per pixel."""
    rng = np.random.default_rng(seed)
    number = rng.poisson(rate_hz * width * height * duration_us * 1e-6)
    return _scatter(
        rng, rng.integers(0, width, number), rng.integers(0, height, number), duration_us
    )


def hot_pixels(number: int, rate_hz: float, *, duration_us: int, seed: int = 0) -> Events:
    """Return ON events of some pixels that fire at `rate_hz` each."""
    rng = np.random.default_rng(seed)
    counts = rng.poisson(rate_hz * duration_us * 1e-6, number)
    xs = np.repeat(rng.integers(0, WIDTH, number), counts)
    ys = np.repeat(rng.integers(0, HEIGHT, number), counts)
    events = _scatter(rng, xs, ys, duration_us)
    events["p"] = True
    return events


def _scatter(rng: np.random.Generator, xs: Any, ys: Any, duration_us: int) -> Events:
    events = np.zeros(len(xs), EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, duration_us, len(xs)))
    order = rng.permutation(len(xs))
    events["x"], events["y"] = xs[order], ys[order]
    events["p"] = rng.random(len(xs)) < 0.5
    return events


def merged(*streams: Events) -> Events:
    """Merge several streams into one sorted stream."""
    events = np.concatenate(streams)
    return events[np.argsort(events["t"], kind="stable")]


def turned(events: Events, direction: Direction, *, width: int, height: int) -> Events:
    """Turn a stream that moves right on a `width`×`height` image to another direction.

    Up and down exchange x and y, so that their image is `height`×`width`.
    """
    out = events.copy()
    if direction in (Direction.LEFT, Direction.UP):
        out["x"] = width - 1 - events["x"]
    if direction in (Direction.UP, Direction.DOWN):
        out["x"], out["y"] = events["y"], out["x"].copy()
    return out


def crossing(
    pattern: F64,
    *,
    speed_px_s: float,
    direction: Direction,
    lead_us: int = 0,
    plain_background: bool = False,
) -> tuple[Events, int]:
    """Return the events of a pattern that crosses the sensor, and its time in view [µs].

    The front of the pattern comes into view at `lead_us`.
    """
    width, height = size_before_turning(direction)
    rightward = _rightward(
        pattern.tobytes(), pattern.shape, speed_px_s, (width, height), plain_background
    )
    events = turned(rightward, direction, width=width, height=height)
    events["t"] += lead_us
    return events, _in_view_us(pattern.shape[1], speed_px_s, width)


def size_before_turning(direction: Direction) -> tuple[int, int]:
    """Return the size of the image from which `turned` makes a stream that fits the sensor."""
    upright = direction in (Direction.RIGHT, Direction.LEFT)
    return (WIDTH, HEIGHT) if upright else (HEIGHT, WIDTH)


def _in_view_us(length_px: int, speed_px_s: float, width: int) -> int:
    return int((width + length_px) / speed_px_s * 1e6)


@lru_cache(maxsize=64)
def _rightward(
    data: bytes, shape: tuple[int, int], speed: float, size: tuple[int, int], plain_background: bool
) -> Events:
    width, height = size
    return slide(
        np.frombuffer(data).reshape(shape),
        speed_px_s=speed,
        start_px=-shape[1],
        top_px=(height - shape[0]) // 2,
        duration_us=_in_view_us(shape[1], speed, width),
        background=np.zeros((height, width)) if plain_background else asphalt(height, width),
    )
