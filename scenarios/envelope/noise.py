"""Poisson noise of all pixels, and merging of two event streams."""

from __future__ import annotations

from typing import Any

import numpy as np

from flybench.events import EVENT_DTYPE, Events
from flybench.kernels import compiled


def poisson_noise(
    rate_hz: float, *, width: int, height: int, duration_us: int, rng: np.random.Generator
) -> Events:
    """Return events of a homogeneous Poisson process in every pixel; polarities are equally likely.

    Args:
        rate_hz: rate per pixel [Hz].
        width: sensor columns [px].
        height: sensor rows [px].
        duration_us: events lie in [0, duration) [µs].
        rng: random generator.

    Returns:
        Events, sorted by t.
    """
    number = int(rng.poisson(rate_hz * width * height * duration_us * 1e-6))
    events = np.empty(number, EVENT_DTYPE)
    waits = np.cumsum(rng.standard_exponential(number + 1))
    events["t"] = waits[:-1] / waits[-1] * duration_us  # these are sorted uniform numbers
    pixel = rng.integers(0, 2 * width * height, number, np.int32)
    events["p"], pixel = pixel & 1, pixel >> 1
    events["y"], events["x"] = np.divmod(pixel, width)
    return events


def merge_streams(first: Events, second: Events) -> Events:
    """Merge two sorted streams; of simultaneous events, those of the first stream come first.

    This takes a quarter of the time of a stable sort with NumPy.
    """
    merged = np.empty(first.size + second.size, EVENT_DTYPE)
    _merge_sorted(first, second, merged)
    return merged


@compiled
def _merge_sorted(first: Any, second: Any, merged: Any) -> None:
    i = j = 0
    for n in range(merged.size):
        if j == second.size or (i < first.size and first[i].t <= second[j].t):
            merged[n] = first[i]
            i += 1
        else:
            merged[n] = second[j]
            j += 1
