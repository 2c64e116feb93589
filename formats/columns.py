"""Events on their way out of a file: columns of any kind in, sorted sound events out.

This module and `readers` run in the process that parses files, which starts in a fraction of a
second since it imports nothing of the bench.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from formats.errors import FormatError

RAW_DTYPE = np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "?")])
"""The same as the bench's own event type, which is not imported here."""

UNITS_US = {"s": 1e6, "ms": 1e3, "us": 1.0, "ns": 1e-3}
"""Units of time in µs."""

SIDE_MAX = 32767
"""Largest width or height: coordinates have 16 bits with a sign [px]."""

CLOCK_US = 10**14
"""A first time beyond this, three years, is a wall clock's and not a recording's [µs]."""

_TIME_MAX_US = 2**62
_NS_FROM = 10**17

Size: TypeAlias = tuple[int, int]
Array: TypeAlias = npt.NDArray[Any]


@dataclass(frozen=True)
class Options:
    """What the user said about a file.

    Attributes:
        size: sensor's width and height [px]; None: not said.
        time_unit: one of `UNITS_US`; None: not said.
    """

    size: Size | None = None
    time_unit: str | None = None


@dataclass(frozen=True)
class Head:
    """What a file says of itself.

    Attributes:
        size: sensor's width and height [px]; None: it does not say.
        says: other facts, to be shown.
        has_frames: whether frames are among its items.
    """

    size: Size | None = None
    says: dict[str, str] = field(default_factory=dict)
    has_frames: bool = False


@dataclass(frozen=True, eq=False)
class Columns:
    """Some events as columns of equal length; time in µs, polarity -1, 0 or 1."""

    t: Array
    x: Array
    y: Array
    p: Array


@dataclass(frozen=True, eq=False)
class RawFrame:
    """A frame: exposure in µs, image (height, width) uint16 in DN of 10 bits."""

    start_us: int
    end_us: int
    image: npt.NDArray[np.uint16]


Item: TypeAlias = Columns | RawFrame
Reading: TypeAlias = tuple[Head, Iterator[Item]]


def microseconds(time: Array, unit: str | None, *, path: Path) -> Array:
    """A column of time in µs, int64.

    Args:
        time: as it is in the file.
        unit: one of `UNITS_US`; None: s if the column is of floats, ns if it is of integers
            beyond 10¹⁷, else µs.
        path: the file, for messages.
    """
    if unit is None:
        if np.issubdtype(time.dtype, np.floating):
            unit = "s"
        else:
            unit = "ns" if time.size and int(time[0]) >= _NS_FROM else "us"
    if np.issubdtype(time.dtype, np.floating):
        scaled = time * UNITS_US[unit]
        if time.size and not np.all(np.abs(scaled) < _TIME_MAX_US):
            raise FormatError(f"{path} has a time that is no number of {unit}; repair that event")
        return np.rint(scaled).astype(np.int64)
    if time.size and int(time.max()) > _TIME_MAX_US:
        raise FormatError(f"{path} has the time {int(time.max())} {unit}, too large; repair it")
    if unit == "ns":
        return time.astype(np.int64) // 1000
    return time.astype(np.int64) * int(UNITS_US[unit])


def pack(columns: Columns, size: Size | None, *, path: Path, done: int) -> Array:
    """Columns as events of `RAW_DTYPE`, checked but for their order.

    Args:
        columns: some events.
        size: sensor [px]; None: not known yet.
        path: the file, for messages.
        done: events before these, for messages.

    Raises:
        FormatError: a coordinate is not whole or off the sensor, or a polarity is none.
    """
    events = np.empty(columns.t.size, RAW_DTYPE)
    if not columns.t.size:
        return events
    width, height = size or (SIDE_MAX, SIDE_MAX)
    for name, values, limit in (("x", columns.x, width), ("y", columns.y, height)):
        _check_range(values, 0, limit - 1, name, path=path, done=done)
    _check_range(columns.p, -1, 1, "p", path=path, done=done)
    events["t"], events["x"], events["y"] = columns.t, columns.x, columns.y
    events["p"] = columns.p if columns.p.dtype == np.bool_ else columns.p > 0
    return events


def check_order(events: Array, last_us: int | None, *, path: Path, done: int) -> None:
    """Refuse time that goes back, within the events or from those before."""
    t = events["t"]
    if last_us is not None and int(t[0]) < last_us:
        raise _disorder(path, done, int(t[0]), last_us)
    backwards = t[1:] < t[:-1]
    if backwards.any():
        i = int(np.argmax(backwards))
        raise _disorder(path, done + i + 1, int(t[i + 1]), int(t[i]))


def _disorder(path: Path, number: int, t_us: int, before_us: int) -> FormatError:
    return FormatError(
        f"{path}: event {number} has the time {t_us} µs after {before_us} µs; time must not go "
        "back; sort the events by time, or cut the file where its clock was reset"
    )


def _check_range(values: Array, low: int, high: int, name: str, *, path: Path, done: int) -> None:
    if values.dtype == np.bool_:
        return
    least, most = values.min(), values.max()
    if low <= least and most <= high:
        if np.issubdtype(values.dtype, np.floating) and (values != np.rint(values)).any():
            i = int(np.argmax(values != np.rint(values)))
            raise FormatError(
                f"{path}: event {done + i} has {name} = {values[i]}, which is not whole; give the "
                "events before their undistortion"
            )
        return
    i = int(np.argmax(~((values >= low) & (values <= high))))
    where = "-1, 0 or 1" if name == "p" else f"0 to {high}"
    remedy = "repair it" if name == "p" else "repair it, or give the sensor's size with --size"
    raise FormatError(
        f"{path}: event {done + i} has {name} = {values[i]}; allowed is {where}; {remedy}"
    )
