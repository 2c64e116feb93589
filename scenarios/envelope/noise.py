"""Poisson noise over the whole sensor, and the merging of two streams."""

from __future__ import annotations

from typing import Any

import numpy as np

from flybench.events import EVENT_DTYPE, Events
from flybench.kernels import compiled


def poisson_noise(
    rate_hz: float, *, width: int, height: int, duration_us: int, rng: np.random.Generator
) -> Events:
    """Events of a homogeneous Poisson process in every pixel, either polarity alike.

    Args:
        rate_hz: by pixel [Hz].
        width: sensor columns [px].
        height: sensor rows [px].
        duration_us: events lie in [0, duration) [µs].
        rng: of everything.

    Returns:
        Events sorted by t.
    """
    number = int(rng.poisson(rate_hz * width * height * duration_us * 1e-6))
    events = np.empty(number, EVENT_DTYPE)
    waits = np.cumsum(rng.standard_exponential(number + 1))
    events["t"] = waits[:-1] / waits[-1] * duration_us  # sorted uniform numbers
    pixel = rng.integers(0, 2 * width * height, number, np.int32)
    events["p"], pixel = pixel & 1, pixel >> 1
    events["y"], events["x"] = np.divmod(pixel, width)
    return events


def merge(first: Events, second: Events) -> Events:
    """One sorted stream of two; of events at the same time, the first stream's come first."""
    merged = np.empty(first.size + second.size, EVENT_DTYPE)
    _merge(first, second, merged)
    return merged


@compiled
def _merge(first: Any, second: Any, merged: Any) -> None:
    i = j = 0
    for n in range(merged.size):
        if j == second.size or (i < first.size and first[i].t <= second[j].t):
            merged[n] = first[i]
            i += 1
        else:
            merged[n] = second[j]
            j += 1
