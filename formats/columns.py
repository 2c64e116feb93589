"""Data types of the parser, and the checks that turn columns of any dtype into sorted events.

This module and `readers` run in the process that parses files. They import nothing of flybench but
its errors, so that this process starts in a fraction of a second.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from formats.errors import FormatError

PARSED_DTYPE = np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "?")])
"""Dtype of events; a copy of `flybench.events.EVENT_DTYPE`, which is not imported here."""

MAX_SIDE_PX = 32767
"""Largest width or height of a sensor: coordinates are signed 16-bit integers [px]."""

WALL_CLOCK_MIN_US = 10**14
"""A first timestamp of three years or more is taken as wall-clock time [µs]."""

Size: TypeAlias = tuple[int, int]
Array: TypeAlias = npt.NDArray[Any]


@dataclass(frozen=True)
class ReadOptions:
    """What the user states about a file.

    Attributes:
        size: width and height of the sensor [px]; None: not stated.
        time_unit: unit of the timestamps, as `formats.time_unit.unit_us` takes it; None: not
            stated.
        columns: a letter of each column, such as "txyp"; "-" for one that is not read; None: not
            stated.
        sort_within_us: events that are late by no more than this are put in order [µs]; 0: none.
        drop_unsorted: True if events that are out of order are dropped.
    """

    size: Size | None = None
    time_unit: str | None = None
    columns: str | None = None
    sort_within_us: int = 0
    drop_unsorted: bool = False


@dataclass(frozen=True)
class FileHeader:
    """What a file states about its content.

    Attributes:
        size: width and height of the sensor [px]; None: not stated.
        facts: other facts, by the name to display them under.
        has_frames: True if the file contains frames.
        size_source: what states the size.
        possible_sizes: sizes that the sensor may have if `size` is None; empty: any.
        time_unit: unit of the timestamps in `EventColumns` and `ParsedFrame`; None: not stated, to
            be recognised by their values.
        unit_source: what states that unit.
    """

    size: Size | None = None
    facts: dict[str, str] = field(default_factory=dict)
    has_frames: bool = False
    size_source: str = "the file"
    possible_sizes: tuple[Size, ...] = ()
    time_unit: str | None = "us"
    unit_source: str = "as the format defines"


@dataclass(frozen=True, eq=False)
class EventColumns:
    """A block of events as columns of equal length.

    Attributes:
        t: timestamps, in the unit that the file's header states.
        x: columns of the pixels [px].
        y: rows of the pixels [px].
        p: polarities: -1, 0 or 1, or booleans.
    """

    t: Array
    x: Array
    y: Array
    p: Array

    def first(self, count: int) -> EventColumns:
        """Return the first events of the block."""
        if count == self.t.size:
            return self
        return EventColumns(self.t[:count], self.x[:count], self.y[:count], self.p[:count])


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


ParsedItem: TypeAlias = EventColumns | ParsedFrame
ParsedFile: TypeAlias = tuple[FileHeader, Iterator[ParsedItem]]


def valid_length(
    columns: EventColumns, size: Size, *, path: Path, done: int, size_is_option: bool = False
) -> tuple[int, FormatError | None]:
    """Return the number of valid events at the start of a block, and what is wrong with the next.

    Args:
        columns: the block.
        size: width and height of the sensor [px].
        path: path of the file, for the message.
        done: number of events before this block, for the message.
        size_is_option: True if the user states the size.

    Returns:
        The number, and an error: a coordinate is not a whole number or outside the sensor, or a
        polarity is not -1, 0 or 1. None if all events are valid.
    """
    end, bad = columns.t.size, ""
    for name, values, low, high in (
        ("x", columns.x, 0, size[0] - 1),
        ("y", columns.y, 0, size[1] - 1),
        ("p", columns.p, -1, 1),
    ):
        first = _first_invalid(values[:end], low, high)
        if first is not None:
            end, bad = first, name
    if not bad:
        return end, None
    value = getattr(columns, bad)[end]
    reason = _reason(bad, value, size, size_is_option)
    return end, FormatError(f"{path}: event {done + end} has {bad} = {value}. {reason}")


def to_events(columns: EventColumns) -> Array:
    """Return valid columns as an array of `PARSED_DTYPE`; their order in time is not checked."""
    events = np.empty(columns.t.size, PARSED_DTYPE)
    events["t"], events["x"], events["y"] = columns.t, columns.x, columns.y
    events["p"] = columns.p if columns.p.dtype == np.bool_ else columns.p > 0
    return events


def joined(parts: Sequence[Array]) -> Array:
    """Return parts of a stream as one array of `PARSED_DTYPE`.

    They are copied as bytes: NumPy copies packed records field by field, 30 times as slowly.
    """
    if len(parts) == 1:
        return parts[0]
    whole: Array = np.concatenate([part.view(np.uint8) for part in parts]).view(PARSED_DTYPE)
    return whole


def _first_invalid(values: Array, low: int, high: int) -> int | None:
    """Return the index of the first value that is not a whole number from low to high."""
    if not values.size or values.dtype == np.bool_:
        return None
    fractional = np.issubdtype(values.dtype, np.floating)
    if low <= values.min() and values.max() <= high and not fractional:
        return None
    valid = (values >= low) & (values <= high)
    if fractional:
        valid &= values == np.rint(values)
    return None if valid.all() else int(np.argmin(valid))


def _reason(name: str, value: Any, size: Size, size_is_option: bool) -> str:
    if name == "p":
        return "Allowed is -1, 0 or 1. Repair or remove that event."
    limit = size["xy".index(name)] - 1
    if 0 <= value <= limit:
        return "Allowed is a whole number. Use the events as they were before undistortion."
    if size_is_option and value > limit:
        return (
            f"The size of the sensor is given as {size[0]}x{size[1]}, so that 0 to {limit} is "
            "allowed. Give a larger size with --size, or remove that event."
        )
    return (
        f"Allowed is 0 to {limit}. Repair or remove that event, or state the sensor's size with "
        "--size."
    )
