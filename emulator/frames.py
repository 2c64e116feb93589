"""What a luminance frame must be."""

from __future__ import annotations

from operator import index

import numpy as np
import numpy.typing as npt

from emulator.errors import FrameError
from emulator.event_keys import MAX_STEP_US

MAX_LUMINANCE_CD_M2 = 1e10
"""Brightest light that the sensor takes: six times the disc of the sun."""


def check_luminance(
    luminance_cd_m2: npt.ArrayLike, *, width: int, height: int
) -> npt.NDArray[np.float32]:
    """Refuse what cannot be light.

    Args:
        luminance_cd_m2: candidate frame [cd/m²].
        width: sensor columns [px].
        height: sensor rows [px].

    Returns:
        The frame, (height, width) float32, contiguous; the same array where it was one already.

    Raises:
        FrameError: another shape, not floating point, NaN, negative, or brighter than
            `MAX_LUMINANCE_CD_M2`.
    """
    frame = np.asarray(luminance_cd_m2)
    if frame.shape != (height, width):
        raise FrameError(
            f"the frame has shape {frame.shape}; allowed is ({height}, {width}), rows by columns; "
            "render at the sensor's size or give SensorConfig the size of the frame"
        )
    if not np.issubdtype(frame.dtype, np.floating):
        raise FrameError(
            f"the frame has dtype {frame.dtype}; allowed is floating point luminance in cd/m²; "
            "multiply grey levels by the cd/m² of one level first"
        )
    with np.errstate(over="ignore"):
        frame = np.ascontiguousarray(frame, np.float32)
    if not (frame.min() >= 0.0 and frame.max() <= MAX_LUMINANCE_CD_M2):
        bad = np.argwhere(~((frame >= 0.0) & (frame <= MAX_LUMINANCE_CD_M2)))[0]
        raise FrameError(
            f"the frame has luminance {frame[tuple(bad)]} cd/m² at row {bad[0]}, column {bad[1]}; "
            f"allowed is 0 to {MAX_LUMINANCE_CD_M2:g} cd/m²; mend the renderer or clip the frame"
        )
    return frame


def check_time(t_us: int, last_us: int | None) -> int:
    """Refuse a time that is not later than the last one, or too much later.

    Args:
        t_us: time of the frame [µs].
        last_us: time of the frame before [µs], None for the first.

    Returns:
        The time as a Python integer.

    Raises:
        FrameError: not an integer, not later than `last_us`, or a step above `MAX_STEP_US`.
    """
    try:
        time_us = index(t_us)
    except TypeError:
        raise FrameError(
            f"the time is {t_us!r}; allowed is a whole number of µs; round it first"
        ) from None
    if last_us is not None and not last_us < time_us <= last_us + MAX_STEP_US:
        raise FrameError(
            f"the time is {time_us} µs after a frame at {last_us} µs; allowed is {last_us + 1} to "
            f"{last_us + MAX_STEP_US} µs; pass frames in order, each once, without gaps of minutes"
        )
    return time_us
