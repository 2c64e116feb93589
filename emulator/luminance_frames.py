"""Checks of the luminance frames that a sensor takes."""

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
"""Largest time, positive or negative: events carry 64-bit times, and later steps must fit too."""

MAX_LUMINANCE_CD_M2 = 1e10
"""Highest luminance that the sensor accepts: six times that of the sun's disc."""

_FLOAT32_BYTES = 4


def time_luminance_pairs(
    samples: Iterable[tuple[int, npt.ArrayLike]],
) -> Iterator[tuple[int, npt.ArrayLike]]:
    """Iterate over (time, luminance) pairs.

    Raises:
        FrameError: the argument is not iterable, or an item is no pair.
    """
    try:
        iterator = iter(samples)
    except TypeError:
        raise FrameError(
            f"the frames are {samples!r}. Allowed is an iterable of pairs of time [µs] and "
            "luminance [cd/m²]. Give a list or a generator."
        ) from None
    for item in iterator:
        try:
            t_us, luminance_cd_m2 = item
        except (TypeError, ValueError):
            raise FrameError(
                f"An item of the frames is not a pair but a {type(item).__name__}. Allowed are "
                "pairs of time [µs] and luminance [cd/m²]. Yield them as t_us, luminance."
            ) from None
        yield t_us, luminance_cd_m2


def check_frame(
    luminance_cd_m2: npt.ArrayLike, *, width: int, height: int
) -> npt.NDArray[np.float32]:
    """Check the shape and type of a frame, and convert it to float32.

    The values are checked later, by `check_luminance`, and only where they have changed.

    Args:
        luminance_cd_m2: candidate frame [cd/m²].
        width: sensor columns [px].
        height: sensor rows [px].

    Returns:
        The frame, (height, width) float32, contiguous; the same array if it was one already.

    Raises:
        FrameError: another shape, not floating point, or a negative value so small that float32
            would round it to zero.
    """
    try:
        frame = np.asarray(luminance_cd_m2)
    except (TypeError, ValueError):
        raise FrameError(
            f"the frame is a {type(luminance_cd_m2).__name__} that cannot become an array. Allowed "
            f"is ({height}, {width}) floating point luminance. Give all rows the same length."
        ) from None
    if frame.shape != (height, width):
        raise FrameError(
            f"the frame has shape {frame.shape}. Allowed is ({height}, {width}), rows by columns. "
            "Render at the size of the sensor, or give SensorConfig the size of the frame."
        )
    if frame.dtype == np.float32:
        return np.ascontiguousarray(frame)
    if not np.issubdtype(frame.dtype, np.floating):
        raise FrameError(
            f"the frame has dtype {frame.dtype}. Allowed is floating point luminance in cd/m². "
            "Convert grey levels with luminance_of."
        )
    if frame.itemsize > _FLOAT32_BYTES and (frame < 0.0).any():
        check_luminance(frame)
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(frame, np.float32)


def check_luminance(frame: npt.NDArray[np.floating]) -> None:
    """Check that all values of a frame are valid luminances.

    Args:
        frame: (height, width) luminance [cd/m²].

    Raises:
        FrameError: NaN, negative, or above `MAX_LUMINANCE_CD_M2`.
    """
    if not (frame.min() >= 0.0 and frame.max() <= MAX_LUMINANCE_CD_M2):
        bad = np.argwhere(~((frame >= 0.0) & (frame <= MAX_LUMINANCE_CD_M2)))[0]
        raise FrameError(
            f"the frame has luminance {frame[tuple(bad)]} cd/m² at row {bad[0]}, column {bad[1]}. "
            f"Allowed is 0 to {MAX_LUMINANCE_CD_M2:g} cd/m². Correct the renderer or clip the "
            "frame."
        )


def check_rectangle(rectangle: Rectangle, *, width: int, height: int) -> Rectangle:
    """Check that a rectangle lies on the sensor.

    Args:
        rectangle: x0, y0, x1, y1, the last two exclusive [px]; it may be empty.
        width: sensor columns [px].
        height: sensor rows [px].

    Returns:
        The rectangle as Python integers.

    Raises:
        FrameError: not four integers in order, or beyond the sensor.
    """
    try:
        x0, y0, x1, y1 = (index(bound) for bound in rectangle)
    except (TypeError, ValueError):
        x0, y0, x1, y1 = 1, 1, 0, 0
    if not (0 <= x0 <= x1 <= width and 0 <= y0 <= y1 <= height):
        raise FrameError(
            f"the changed rectangle is {rectangle!r}. Allowed is x0, y0, x1, y1 with "
            f"0 <= x0 <= x1 <= {width} and 0 <= y0 <= y1 <= {height}. Pass None if it is not known."
        )
    return x0, y0, x1, y1


def check_time(t_us: int, last_us: int | None) -> int:
    """Check that a time is later than the last one, and not too much later.

    Args:
        t_us: time of the frame [µs].
        last_us: time of the previous frame [µs], None for the first.

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
            f"the time is {t_us!r}. Allowed is a whole number of µs. Round it first."
        ) from None
    if abs(time_us) > MAX_TIME_US:
        raise FrameError(
            f"the time is {time_us} µs. Allowed is -{MAX_TIME_US} to {MAX_TIME_US} µs, so that "
            "events carry it in 64 bits. Count from the start of the recording."
        )
    if last_us is not None and not last_us < time_us <= last_us + MAX_STEP_US:
        raise FrameError(
            f"the time is {time_us} µs after a frame at {last_us} µs. Allowed is {last_us + 1} to "
            f"{last_us + MAX_STEP_US} µs. Pass each frame once, in order, without gaps of minutes."
        )
    return time_us
