"""The checks on a chunk of events that run before it changes a detector."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.errors import EventOrderError
from flybench.errors import EventError
from flybench.events import EVENT_DTYPE, Events, check_events
from flybench.kernels import compiled
from flybench.memory import check_memory

_RAW_DTYPE = np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "u1")])
"""`EVENT_DTYPE` with the polarity byte as a number."""

_LATEST_US = 2**62
"""Latest allowed time [µs], 146 000 years: the end of any later hop still fits into 64 bits."""

_ESTIMATE_BYTES = 600
"""Memory of an estimate in a list (measured: 520) [bytes]."""
_FEW = 100_000
"""Estimates that are not counted exactly, because they are few [60 MB]."""


def check_chunk(events: Events, *, width: int, height: int, now_us: int) -> None:
    """Refuse a chunk of events that does not continue the stream.

    One compiled pass detects whether anything is wrong. Slower checks find the cause only in that
    case, so that chunks of a hundred events remain cheap.

    Args:
        events: candidate chunk.
        width: sensor columns [px].
        height: sensor rows [px].
        now_us: time that the stream has reached [µs].

    Raises:
        EventError: the chunk is not a sorted stream of `EVENT_DTYPE` from this sensor.
        EventOrderError: its first event is before `now_us`, or its last is later than allowed.
    """
    is_array = isinstance(events, np.ndarray) and events.dtype == EVENT_DTYPE and events.ndim == 1
    if is_array and _is_valid(events, width, height, now_us):
        return
    check_events(events, width=width, height=height)
    check_order(int(events["t"][0]), now_us)
    checked_time(int(events["t"][-1]))
    polarity = events.view(_RAW_DTYPE)["p"]
    raise EventError(
        f"An event has the polarity byte {polarity.max()}. Allowed is 0 (OFF) or 1 (ON). "
        "Set p = raw > 0 when making the array."
    )


def check_order(t_us: int, now_us: int) -> None:
    """Refuse a time before 0 or before the time that the stream has reached.

    Raises:
        EventOrderError: `t_us` is before `now_us` or before 0.
    """
    if t_us < 0:
        raise EventOrderError(
            f"Time {t_us} µs is before 0. Allowed times start at 0. Subtract the first time of the "
            "stream from all times."
        )
    if t_us < now_us:
        raise EventOrderError(
            f"Time {t_us} µs comes after time {now_us} µs, but time must not go back between "
            "calls. Pass the chunks in order, or make a new detector for a new stream."
        )


def checked_time(t_us: int) -> int:
    """Return a time as a Python int.

    Raises:
        EventOrderError: `t_us` is not a whole number (NaN, for example, has no order), or is later
            than allowed.
    """
    try:
        time_us = operator.index(t_us)
    except TypeError:
        raise EventOrderError(
            f"The time is {t_us!r}. Allowed is a whole number of µs. Round it first."
        ) from None
    if time_us > _LATEST_US:
        raise EventOrderError(
            f"The time is {time_us} µs. Allowed is up to {_LATEST_US} µs. Count times in µs from "
            "the start of the stream."
        )
    return time_us


def check_pause(hop_us: int, quiet_limit_us: int) -> None:
    """Refuse a hop so short that the estimates of one pause do not fit into memory.

    Args:
        hop_us: step between estimates [µs].
        quiet_limit_us: time after the last event at which estimates stop [µs].

    Raises:
        MemoryBudgetError: they do not fit into the memory budget.
    """
    number = quiet_limit_us // hop_us
    what = f"A pause of quiet_limit_us = {quiet_limit_us} µs with an estimate every {hop_us} µs"
    check_memory(what, number * _ESTIMATE_BYTES)


def check_estimates(
    times_us: npt.NDArray[np.int64], *, now_us: int, hop_us: int, quiet_limit_us: int
) -> None:
    """Refuse a chunk of events whose estimates do not fit into memory.

    Args:
        times_us: times of the events, sorted; at least one [µs].
        now_us: time that the stream has reached [µs].
        hop_us: step between estimates [µs].
        quiet_limit_us: time after an event at which estimates stop [µs].

    Raises:
        MemoryBudgetError: they do not fit into the memory budget.
    """
    number = (int(times_us[-1]) - now_us) // hop_us
    if number <= _FEW:
        return
    pauses_us = np.diff(times_us, prepend=now_us)
    number = int(np.minimum(pauses_us, quiet_limit_us).sum()) // hop_us
    what = f"A chunk of {times_us.size} events with {number} estimates"
    check_memory(what, number * _ESTIMATE_BYTES)


@compiled
def _is_valid(events: Any, width: int, height: int, now_us: int) -> bool:
    before = now_us
    raw = events.view(_RAW_DTYPE)
    for n in range(raw.size):
        event = raw[n]
        inside = 0 <= event.x < width and 0 <= event.y < height
        if event.t < before or not inside or event.p > 1:
            return False
        before = event.t
    return bool(before <= _LATEST_US)
