"""Streams of events with known statistics."""

from __future__ import annotations

from typing import Any

import numpy as np

from flybench.events import EVENT_DTYPE, Events

SIZE: Any = {"width": 32, "height": 24}


def events_of(*rows: tuple[int, int, int, int]) -> Events:
    """Events from tuples of t [µs], x, y and p."""
    return np.array(list(rows), EVENT_DTYPE)


def noise_events(rate_hz: float, duration_us: int, seed: int = 0) -> Events:
    """Poisson noise of both polarities, each at this rate, at every pixel of `SIZE`."""
    rng = np.random.default_rng(seed)
    pixels = SIZE["width"] * SIZE["height"]
    count = rng.poisson(2 * rate_hz * pixels * duration_us * 1e-6)
    events = np.empty(count, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, duration_us, count))
    events["x"] = rng.integers(0, SIZE["width"], count)
    events["y"] = rng.integers(0, SIZE["height"], count)
    events["p"] = rng.integers(0, 2, count)
    return events


def edge_events(*, px_s: float, events_each: int, apart_us: int = 2000) -> Events:
    """A vertical ON edge that crosses `SIZE` once; every pixel fires the same number of events."""
    y, x, k = np.mgrid[: SIZE["height"], : SIZE["width"], :events_each]
    events = np.empty(y.size, EVENT_DTYPE)
    events["t"] = (x / px_s * 1e6 + k * apart_us).astype(np.int64).ravel()
    events["x"], events["y"], events["p"] = x.ravel(), y.ravel(), True
    return events[np.argsort(events["t"], kind="stable")]
