"""What a luminance frame must be."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from operator import index
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from emulator.errors import FrameError
from emulator.readout.event_keys import MAX_STEP_US

Rectangle: TypeAlias = tuple[int, int, int, int]
"""x0, y0, x1, y1 of a rectangle of pixels, the last two exclusive."""

MAX_TIME_US = 2**62
"""Farthest time from zero: events carry 64-bit times, and what follows a frame must fit too."""

MAX_LUMINANCE_CD_M2 = 1e10
"""Brightest light that the sensor takes: six times the disc of the sun."""

_ITEM_BYTES = 4
"""Of float32: what is wider is rounded to it."""


def pairs(
    samples: Iterable[tuple[int, npt.ArrayLike]],
) -> Iterator[tuple[int, npt.ArrayLike]]:
    """Go through (time, luminance) pairs.

    Raises:
        FrameError: what is given cannot be gone through, or an item is no pair.
    """
    try:
        iterator = iter(samples)
    except TypeError:
        raise FrameError(
            f"the frames are {samples!r}; allowed is an iterable of (time [µs], luminance [cd/m²]) "
            "pairs; give a list or a generator of them"
        ) from None
    for item in iterator:
        try:
            t_us, luminance_cd_m2 = item
        except (TypeError, ValueError):
            raise FrameError(
                f"the frames hold a {type(item).__name__} that is no pair; allowed are (time [µs], "
                "luminance [cd/m²]) pairs; yield them as t_us, luminance"
            ) from None
        yield t_us, luminance_cd_m2


def check_frame(
    luminance_cd_m2: npt.ArrayLike, *, width: int, height: int
) -> npt.NDArray[np.float32]:
    """Refuse what cannot be a frame of light, without a look at the light itself.

    Args:
        luminance_cd_m2: candidate frame [cd/m²].
        width: sensor columns [px].
        height: sensor rows [px].

    Returns:
        The frame, (height, width) float32, contiguous; the same array where it was one already.

    Raises:
        FrameError: another shape, not floating point, or negative by so little that it would be
            rounded to zero.
    """
    try:
        frame = np.asarray(luminance_cd_m2)
    except (TypeError, ValueError):
        raise FrameError(
            f"the frame is a {type(luminance_cd_m2).__name__} that makes no array; allowed is "
            f"({height}, {width}) floating point luminance; give every row the same length"
        ) from None
    if frame.shape != (height, width):
        raise FrameError(
            f"the frame has shape {frame.shape}; allowed is ({height}, {width}), rows by columns; "
            "render at the sensor's size or give SensorConfig the size of the frame"
        )
    if frame.dtype == np.float32:
        return np.ascontiguousarray(frame)
    if not np.issubdtype(frame.dtype, np.floating):
        raise FrameError(
            f"the frame has dtype {frame.dtype}; allowed is floating point luminance in cd/m²; "
            "multiply grey levels by the cd/m² of one level first"
        )
    if frame.itemsize > _ITEM_BYTES and (frame < 0.0).any():
        check_luminance(frame)
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(frame, np.float32)


def check_luminance(frame: npt.NDArray[np.floating]) -> None:
    """Refuse what cannot be light.

    Args:
        frame: (height, width) luminance [cd/m²].

    Raises:
        FrameError: NaN, negative, or brighter than `MAX_LUMINANCE_CD_M2`.
    """
    if not (frame.min() >= 0.0 and frame.max() <= MAX_LUMINANCE_CD_M2):
        bad = np.argwhere(~((frame >= 0.0) & (frame <= MAX_LUMINANCE_CD_M2)))[0]
        raise FrameError(
            f"the frame has luminance {frame[tuple(bad)]} cd/m² at row {bad[0]}, column {bad[1]}; "
            f"allowed is 0 to {MAX_LUMINANCE_CD_M2:g} cd/m²; mend the renderer or clip the frame"
        )


def check_rectangle(rectangle: Rectangle, *, width: int, height: int) -> Rectangle:
    """Refuse what is not a rectangle of the sensor.

    Args:
        rectangle: x0, y0, x1, y1, the last two exclusive [px]; it may be empty.
        width: sensor columns [px].
        height: sensor rows [px].

    Returns:
        The rectangle, of Python integers.

    Raises:
        FrameError: not four integers in order, or beyond the sensor.
    """
    try:
        x0, y0, x1, y1 = (index(bound) for bound in rectangle)
    except (TypeError, ValueError):
        x0, y0, x1, y1 = 1, 1, 0, 0
    if not (0 <= x0 <= x1 <= width and 0 <= y0 <= y1 <= height):
        raise FrameError(
            f"the rectangle of what changed is {rectangle!r}; allowed is x0, y0, x1, y1 with "
            f"0 <= x0 <= x1 <= {width} and 0 <= y0 <= y1 <= {height}; pass None if it is not known"
        )
    return x0, y0, x1, y1


def check_time(t_us: int, last_us: int | None) -> int:
    """Refuse a time that is not later than the last one, or too much later.

    Args:
        t_us: time of the frame [µs].
        last_us: time of the frame before [µs], None for the first.

    Returns:
        The time as a Python integer.

    Raises:
        FrameError: not an integer, beyond ±`MAX_TIME_US`, not later than `last_us`, or a step
            above `MAX_STEP_US`.
    """
    try:
        time_us = index(t_us)
    except TypeError:
        raise FrameError(
            f"the time is {t_us!r}; allowed is a whole number of µs; round it first"
        ) from None
    if abs(time_us) > MAX_TIME_US:
        raise FrameError(
            f"the time is {time_us} µs; allowed is -{MAX_TIME_US} to {MAX_TIME_US} µs, so that "
            "events carry it in 64 bits; count from the start of the recording"
        )
    if last_us is not None and not last_us < time_us <= last_us + MAX_STEP_US:
        raise FrameError(
            f"the time is {time_us} µs after a frame at {last_us} µs; allowed is {last_us + 1} to "
            f"{last_us + MAX_STEP_US} µs; pass frames in order, each once, without gaps of minutes"
        )
    return time_us
