"""The check on every chunk of events before it changes anything."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np

from detector.errors import EventOrderError
from flybench.errors import EventError
from flybench.events import EVENT_DTYPE, Events, check_events
from flybench.kernels import compiled

_RAW_DTYPE = np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "u1")])
"""`EVENT_DTYPE` with the polarity's byte as a number."""

_LATEST_US = 2**62
"""Latest time, 146 000 years [µs]: the end of any hop after it still fits 64 bits."""


def check_chunk(events: Events, *, width: int, height: int, now_us: int) -> None:
    """Refuse a chunk that cannot go on with the stream.

    One compiled pass finds whether anything is wrong; only then is it looked for, so that chunks
    of a hundred events stay cheap.

    Args:
        events: candidate chunk.
        width: sensor columns [px].
        height: sensor rows [px].
        now_us: time that the stream has reached [µs].

    Raises:
        EventError: no sorted stream of `EVENT_DTYPE` from this sensor.
        EventOrderError: its first event is before `now_us`, or its last later than a stream holds.
    """
    is_array = isinstance(events, np.ndarray) and events.dtype == EVENT_DTYPE and events.ndim == 1
    if is_array and _is_sound(events, width, height, now_us):
        return
    check_events(events, width=width, height=height)
    check_order(int(events["t"][0]), now_us)
    whole_time(int(events["t"][-1]))
    polarity = events.view(_RAW_DTYPE)["p"]
    raise EventError(
        f"an event has the polarity byte {polarity.max()}; allowed is 0 (OFF) or 1 (ON); "
        "set p = raw > 0 when making the array"
    )


def check_order(t_us: int, now_us: int) -> None:
    """Refuse a time before the one that the stream has reached, or before 0.

    Raises:
        EventOrderError: `t_us` is before `now_us` or 0.
    """
    if t_us < 0:
        raise EventOrderError(
            f"time {t_us} µs is before 0; times start at 0; subtract the first time of the stream "
            "from all"
        )
    if t_us < now_us:
        raise EventOrderError(
            f"time {t_us} µs comes after time {now_us} µs; time must not go back between calls; "
            "pass the chunks in order, or make a new detector for a new stream"
        )


def whole_time(t_us: int) -> int:
    """A time as an int.

    Raises:
        EventOrderError: `t_us` is not a whole number, as NaN, which has no order; or it is more
            than a stream holds.
    """
    try:
        time_us = operator.index(t_us)
    except TypeError:
        raise EventOrderError(
            f"the time is {t_us!r}; allowed is a whole number of µs; round it first"
        ) from None
    if time_us > _LATEST_US:
        raise EventOrderError(
            f"the time is {time_us} µs; allowed is up to {_LATEST_US} µs; count from the stream's "
            "start, in µs"
        )
    return time_us


@compiled
def _is_sound(events: Any, width: int, height: int, now_us: int) -> bool:
    before = now_us
    raw = events.view(_RAW_DTYPE)
    for n in range(raw.size):
        event = raw[n]
        inside = 0 <= event.x < width and 0 <= event.y < height
        if event.t < before or not inside or event.p > 1:
            return False
        before = event.t
    return bool(before <= _LATEST_US)
