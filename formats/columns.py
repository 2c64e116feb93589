"""Data types of the parser, and the checks that turn columns of any dtype into sorted events.

This module and `readers` run in the process that parses files. They import nothing of flybench but
its errors, so that this process starts in a fraction of a second.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from formats.errors import FormatError
from formats.samples import ParsedSamples

PARSED_DTYPE = np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "?")])
"""Dtype of events; a copy of `flybench.events.EVENT_DTYPE`, which is not imported here."""

UNITS_US = {"s": 1e6, "ms": 1e3, "us": 1.0, "ns": 1e-3}
"""Units of time in µs."""

MAX_SIDE_PX = 32767
"""Largest width or height of a sensor: coordinates are signed 16-bit integers [px]."""

WALL_CLOCK_MIN_US = 10**14
"""A first timestamp of three years or more is taken as wall-clock time [µs]."""

_TIME_MAX_US = 2**62
_NS_FROM = 10**17

Size: TypeAlias = tuple[int, int]
Array: TypeAlias = npt.NDArray[Any]


@dataclass(frozen=True)
class ReadOptions:
    """What the user states about a file.

    Attributes:
        size: width and height of the sensor [px]; None: not stated.
        time_unit: unit of the timestamps, one of `UNITS_US`; None: not stated.
    """

    size: Size | None = None
    time_unit: str | None = None


@dataclass(frozen=True)
class FileHeader:
    """What a file states about its content.

    Attributes:
        size: width and height of the sensor [px]; None: not stated.
        facts: other facts, by the name to display them under.
        has_frames: True if the file contains frames.
    """

    size: Size | None = None
    facts: dict[str, str] = field(default_factory=dict)
    has_frames: bool = False


@dataclass(frozen=True, eq=False)
class EventColumns:
    """A block of events as columns of equal length.

    Attributes:
        t: timestamps [µs].
        x: columns of the pixels [px].
        y: rows of the pixels [px].
        p: polarities: -1, 0 or 1, or booleans.
    """

    t: Array
    x: Array
    y: Array
    p: Array


@dataclass(frozen=True, eq=False)
class ParsedFrame:
    """One frame of a file.

    Attributes:
        start_us: start of the exposure [µs].
        end_us: end of the exposure [µs].
        image: (height, width) uint16, 10-bit grey levels [DN].
    """

    start_us: int
    end_us: int
    image: npt.NDArray[np.uint16]


ParsedItem: TypeAlias = EventColumns | ParsedFrame | ParsedSamples
ParsedFile: TypeAlias = tuple[FileHeader, Iterator[ParsedItem]]


def to_microseconds(time: Array, unit: str | None, *, path: Path) -> Array:
    """Return timestamps as int64 [µs].

    Args:
        time: timestamps as stored in the file.
        unit: unit of the timestamps, one of `UNITS_US`; None: s for floating-point numbers, ns for
            integers of 10¹⁷ and more, µs for other integers.
        path: path of the file, for error messages.

    Raises:
        FormatError: a timestamp is not finite or too large.
    """
    if unit is None:
        if np.issubdtype(time.dtype, np.floating):
            unit = "s"
        else:
            unit = "ns" if time.size and int(time[0]) >= _NS_FROM else "us"
    if np.issubdtype(time.dtype, np.floating):
        scaled = time * UNITS_US[unit]
        if time.size and not np.all(np.abs(scaled) < _TIME_MAX_US):
            raise FormatError(
                f"{path} has a timestamp that is not a finite number of {unit} below 2^62 µs. "
                "Repair or remove that event."
            )
        return np.rint(scaled).astype(np.int64)
    if time.size and int(time.max()) > _TIME_MAX_US:
        raise FormatError(
            f"{path} has the timestamp {int(time.max())} {unit}. Allowed is up to {_TIME_MAX_US}. "
            "Repair or remove that event."
        )
    if unit == "ns":
        return time.astype(np.int64) // 1000
    return time.astype(np.int64) * int(UNITS_US[unit])


def to_events(columns: EventColumns, size: Size | None, *, path: Path, done: int) -> Array:
    """Return a block of events as an array of `PARSED_DTYPE`; its order in time is not checked.

    Args:
        columns: the block.
        size: width and height of the sensor [px]; None: not known yet.
        path: path of the file, for error messages.
        done: number of events before this block, for error messages.

    Raises:
        FormatError: a coordinate is not a whole number or outside the sensor, or a polarity is not
            -1, 0 or 1.
    """
    events = np.empty(columns.t.size, PARSED_DTYPE)
    if not columns.t.size:
        return events
    width, height = size or (MAX_SIDE_PX, MAX_SIDE_PX)
    for name, values, limit in (("x", columns.x, width), ("y", columns.y, height)):
        _check_range(values, 0, limit - 1, name, path=path, done=done)
    _check_range(columns.p, -1, 1, "p", path=path, done=done)
    events["t"], events["x"], events["y"] = columns.t, columns.x, columns.y
    events["p"] = columns.p if columns.p.dtype == np.bool_ else columns.p > 0
    return events


def check_time_order(events: Array, last_us: int | None, *, path: Path, done: int) -> None:
    """Check that timestamps do not decrease.

    Args:
        events: at least one event of `PARSED_DTYPE`.
        last_us: timestamp of the event before them [µs]; None: there is none.
        path: path of the file, for error messages.
        done: number of events before these, for error messages.

    Raises:
        FormatError: a timestamp is lower than the one before it.
    """
    t = events["t"]
    if last_us is not None and int(t[0]) < last_us:
        raise _time_order_error(path, done, int(t[0]), last_us)
    backwards = t[1:] < t[:-1]
    if backwards.any():
        i = int(np.argmax(backwards))
        raise _time_order_error(path, done + i + 1, int(t[i + 1]), int(t[i]))


def _time_order_error(path: Path, number: int, t_us: int, before_us: int) -> FormatError:
    return FormatError(
        f"{path}: event {number} has the timestamp {t_us} µs, after one at {before_us} µs. "
        "Timestamps must not decrease. Sort the events by time, or split the file where its clock "
        "was reset."
    )


def _check_range(values: Array, low: int, high: int, name: str, *, path: Path, done: int) -> None:
    if values.dtype == np.bool_:
        return
    lowest, highest = values.min(), values.max()
    if low <= lowest and highest <= high:
        if np.issubdtype(values.dtype, np.floating) and (values != np.rint(values)).any():
            i = int(np.argmax(values != np.rint(values)))
            raise FormatError(
                f"{path}: event {done + i} has {name} = {values[i]}. Allowed is a whole number. "
                "Use the events as they were before undistortion."
            )
        return
    i = int(np.argmax(~((values >= low) & (values <= high))))
    allowed = "-1, 0 or 1" if name == "p" else f"0 to {high}"
    remedy = "." if name == "p" else ", or state the sensor's size with --size."
    raise FormatError(
        f"{path}: event {done + i} has {name} = {values[i]}. Allowed is {allowed}. "
        f"Repair or remove that event{remedy}"
    )
