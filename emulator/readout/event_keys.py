"""Events of one step as sortable integers.

A key holds, from its highest bit: time from the start of the step [µs] (30 bits), pixel (30 bits),
cause (2 bits), polarity (1 bit). Sorted integers are therefore sorted by time and then by pixel,
in whatever order the pixels were computed.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from flybench.events import EVENT_DTYPE, Events
from flybench.kernels import compiled

Keys: TypeAlias = npt.NDArray[np.int64]

MAX_STEP_US = 2**30 - 1
"""Longest step whose times fit into a key: 17.9 minutes."""

TIME_SHIFT = 33
"""Position of the lowest bit of the time."""

LOW_BITS = (1 << TIME_SHIFT) - 1
"""Mask of all bits below the time: pixel, cause and polarity."""

PIXEL_MASK = 2**30 - 1


@compiled
def make_key(time_us: float, step_us: int, pixel: int, mark: int) -> int:
    """Return the key of an event.

    The time is rounded up, and clipped to the half-open step (from, to]: a sum of parts of the step
    may exceed the whole by a rounding error, which would otherwise become 1 µs.

    Args:
        time_us: time from the start of the step [µs].
        step_us: duration of the step [µs].
        pixel: index of the pixel.
        mark: 2·cause + polarity.
    """
    offset_us = min(max(1, math.ceil(time_us)), step_us)
    return (offset_us << TIME_SHIFT) | (pixel << 3) | mark


@compiled
def _unpack(
    keys: Keys, start_us: int, width: int, events: Events, causes: npt.NDArray[np.uint8]
) -> None:
    for i in range(keys.size):
        key = keys[i]
        pixel = (key >> 3) & PIXEL_MASK
        events[i].t = start_us + (key >> TIME_SHIFT)
        events[i].x = pixel % width
        events[i].y = pixel // width
        events[i].p = (key & 1) != 0
        causes[i] = (key >> 1) & 3


def unpack_keys(keys: Keys, *, start_us: int, width: int) -> tuple[Events, npt.NDArray[np.uint8]]:
    """Convert sorted keys to events.

    Args:
        keys: (n,) int64, sorted.
        start_us: time of the start of the step [µs].
        width: columns of the sensor [px].

    Returns:
        Events (n,) of `EVENT_DTYPE`, sorted by t and then by pixel, and their causes (n,) uint8.
    """
    events = np.empty(keys.size, EVENT_DTYPE)
    causes = np.empty(keys.size, np.uint8)
    _unpack(keys, start_us, width, events, causes)
    return events, causes
