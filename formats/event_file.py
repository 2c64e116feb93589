"""Read event recordings: one interface for every format."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np

from emulator import ApsFrame
from flybench.events import EVENT_DTYPE, Events, concatenate_events, empty_events
from flybench.memory import check_memory
from flybench.printable import printable
from formats.column_order import check_order
from formats.columns import MAX_SIDE_PX, ReadOptions
from formats.errors import FormatError
from formats.event_order import SORT_MAX_US
from formats.identify import FORMATS, TABLES, check_readable, identify_format
from formats.isolated_reader import IsolatedReader
from formats.parser_process import FRAME
from formats.time_unit import unit_us

_FRAMES_PENDING = 32
"""Most frames that are held back until events reach the end of their exposure (assumed)."""

_LIST_BYTES = 2 * EVENT_DTYPE.itemsize
"""Memory per event while a list of chunks becomes one array [bytes]."""
_FRAMES_KEPT = 2 * _FRAMES_PENDING
"""Frames that exist at once: those held back, and those in use after them (estimated)."""


@dataclass(frozen=True, eq=False)
class Chunk:
    """A section of a recording.

    Attributes:
        events: events sorted by time, none older than those of the previous chunk; may be empty.
        frames: APS frames whose exposure ends no later than the last event.
    """

    events: Events
    frames: tuple[ApsFrame, ...] = ()


@dataclass(frozen=True)
class EventStatistics:
    """Statistics of the part of a recording that has been read.

    Attributes:
        events: number of events.
        on: number of ON events.
        frames: number of APS frames.
        first_us: time of the first event [µs].
        last_us: time of the last event [µs].
        x_min: leftmost column with an event [px].
        x_max: rightmost column with an event [px].
        y_min: topmost row with an event [px].
        y_max: bottommost row with an event [px].
    """

    events: int = 0
    on: int = 0
    frames: int = 0
    first_us: int = 0
    last_us: int = 0
    x_min: int = 0
    x_max: int = 0
    y_min: int = 0
    y_max: int = 0

    @property
    def span_us(self) -> int:
        """Time from the first event to the last [µs]."""
        return self.last_us - self.first_us

    @property
    def rate_hz(self) -> float:
        """Mean event rate [events/s]; 0 if all events have the same time."""
        return self.events / self.span_us * 1e6 if self.span_us else 0.0

    @property
    def on_share(self) -> float:
        """Share of ON events, 0 to 1; 0 if there are no events."""
        return self.on / self.events if self.events else 0.0

    def with_chunk(self, chunk: Chunk) -> EventStatistics:
        """Return the statistics with `chunk` included."""
        events, frames = chunk.events, self.frames + len(chunk.frames)
        if not events.size:
            return replace(self, frames=frames)
        x, y = events["x"], events["y"]
        low = (int(x.min()), int(y.min()))
        high = (int(x.max()), int(y.max()))
        if self.events:
            low = (min(low[0], self.x_min), min(low[1], self.y_min))
            high = (max(high[0], self.x_max), max(high[1], self.y_max))
        return EventStatistics(
            events=self.events + events.size,
            on=self.on + int(np.count_nonzero(events["p"])),
            frames=frames,
            first_us=self.first_us if self.events else int(events["t"][0]),
            last_us=int(events["t"][-1]),
            x_min=low[0],
            x_max=high[0],
            y_min=low[1],
            y_max=high[1],
        )


class EventFile:
    """An open recording; iterate over it once to read its chunks. Use as a context manager.

    Attributes:
        path: path of the file.
        format: name of its format, one of `FORMATS`.
        width: sensor columns [px].
        height: sensor rows [px].
        size_source: source of the sensor's size: "the file", "the option" or "the events".
        has_frames: True if the file states that it contains frames.
        header_fields: other facts in the header, by name.
        origin_us: time that was subtracted from all timestamps [µs]: the first timestamp if it is
            negative or a wall-clock time (10¹⁴ µs and more), else 0.
        warnings: what is uncertain about the file, each with the option that settles it.
        sorted_events: number of late events that were put in order, once all chunks are read; None
            if that was not asked for.
        dropped_events: number of events out of order that were dropped, once all chunks are read;
            None if that was not asked for.
    """

    def __init__(self, path: Path, name: str, options: ReadOptions) -> None:
        """Start to read; use `open_events`, which checks the arguments first.

        Args:
            path: path of the file.
            name: name of its format, one of `FORMATS`.
            options: what the user states about the file.

        Raises:
            FormatError: the header cannot be read.
        """
        self.path = path
        self.format = name
        self._statistics = EventStatistics()
        self._ended = False
        self._reader = IsolatedReader(path, name, options)
        self._messages = self._reader.messages()
        try:
            _, content = next(self._messages)
            header: dict[str, Any] = json.loads(content.decode())
        except BaseException:
            self._reader.close()
            raise
        self.width, self.height = header["size"]
        self.size_source: str = header["size_source"]
        self.has_frames: bool = header["has_frames"]
        facts: dict[str, str] = header["facts"]
        self.header_fields = {printable(name): printable(fact) for name, fact in facts.items()}
        self.origin_us: int = header["origin_us"]
        self.warnings: tuple[str, ...] = tuple(header["warnings"])
        self.sorted_events: int | None = None
        self.dropped_events: int | None = None

    def __enter__(self) -> EventFile:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._reader.close()

    @property
    def statistics(self) -> EventStatistics:
        """Statistics of the chunks read so far."""
        return self._statistics

    def __iter__(self) -> Iterator[Chunk]:
        """Yield the chunks, in constant memory.

        Raises:
            FormatError: the file is truncated, damaged or inconsistent; the chunks before that
                place have been yielded. Or the file has already been read to its end.
        """
        if self._ended:
            raise FormatError(f"{self.path} has been read to its end. Open it again.")
        pending: list[ApsFrame] = []
        for kind, content in self._messages:
            if kind == b"F":
                pending.append(_frame(content))
                if len(pending) > _FRAMES_PENDING:
                    yield self._counted(Chunk(empty_events(), (pending.pop(0),)))
                continue
            if kind == b"C":
                counts = json.loads(content.decode())
                self.sorted_events = counts["sorted_events"]
                self.dropped_events = counts["dropped_events"]
                continue
            events = np.frombuffer(content, EVENT_DTYPE)
            last_us = int(events["t"][-1])
            due = tuple(takewhile(lambda frame: frame.end_us <= last_us, pending))  # noqa: B023
            del pending[: len(due)]
            yield self._counted(Chunk(events, due))
        self._ended = True
        if pending:
            yield self._counted(Chunk(empty_events(), tuple(pending)))

    def _counted(self, chunk: Chunk) -> Chunk:
        self._statistics = self._statistics.with_chunk(chunk)
        return chunk


def open_events(
    path: Path | str,
    *,
    format: str | None = None,  # noqa: A002  (the usual name of this parameter)
    size: tuple[int, int] | None = None,
    time_unit: str | None = None,
    columns: str | None = None,
    sort_within_us: int = 0,
    drop_unsorted: bool = False,
) -> EventFile:
    """Open a recording; its format is recognised by its first bytes.

    Args:
        path: path of the file.
        format: name of the format, one of `FORMATS`; None: recognise it.
        size: width and height of the sensor, if the file does not state them or is wrong [px].
        time_unit: unit of the timestamps, if the file does not state it or is wrong: "s", "ms",
            "us" or "ns", with a number before it for timestamps that count steps, such as "33.3ms"
            or "1/30s". None: what the file states, or recognised by the values.
        columns: order of the columns of a text file or a table without names: a letter of each
            column, such as "txyp", and "-" for one that is not read. None: recognised by the
            values.
        sort_within_us: put events in order that come late by no more than this, 0 to
            `formats.event_order.SORT_MAX_US`; those of this time are held in memory [µs].
        drop_unsorted: drop events that come late (by more than `sort_within_us`), and single
            events from the future.

    Returns:
        The open file, with the facts from its header.

    Raises:
        FormatError: the file cannot be read; the message states why.
        MissingLibraryError: a library is missing; the message states how to install it.
    """
    path = Path(path)
    if format is not None and format not in FORMATS:
        raise FormatError(f"The format is {format!r}. Allowed is one of {', '.join(FORMATS)}.")
    if size is not None and not all(0 < side <= MAX_SIDE_PX for side in size):
        raise FormatError(
            f"The sensor's size is {size[0]}x{size[1]} px. Allowed is 1 to {MAX_SIDE_PX} px in "
            "width and height. Correct the size."
        )
    if time_unit is not None:
        unit_us(time_unit)
    if not 0 <= sort_within_us <= SORT_MAX_US:
        raise FormatError(
            f"Events are to be sorted within {sort_within_us / 1e3:g} ms. Allowed is 0 to "
            f"{SORT_MAX_US / 1e3:g} ms, because all events of that time are held in memory."
        )
    columns = check_order(columns) if columns is not None else None
    check_readable(path)
    name = format or identify_format(path)
    if columns is not None and name not in TABLES:
        raise FormatError(
            f"--columns is {columns}, but {path} is {FORMATS[name]}, which defines its columns. "
            "Leave --columns out."
        )
    options = ReadOptions(size, time_unit, columns, sort_within_us, drop_unsorted)
    return EventFile(path, name, options)


def read_events(path: Path | str, **options: Any) -> Events:
    """Return all events of a file that fits into memory.

    Args:
        path: path of the file.
        **options: options of `open_events`.

    Raises:
        FormatError: the file cannot be read; the message states why.
        MissingLibraryError: a library is missing; the message states how to install it.
        MemoryBudgetError: the events do not fit into the memory budget.
    """
    with open_events(path, **options) as file:
        chunks: list[Events] = []
        number = 0
        for chunk in file:
            number += chunk.events.size
            what = f"The list of the first {number} events of {path}"
            check_memory(what, number * _LIST_BYTES)
            chunks.append(chunk.events)
    return concatenate_events(chunks)


def _frame(content: bytearray) -> ApsFrame:
    start_us, end_us, width, height = FRAME.unpack_from(content)
    check_memory(f"A recording with APS frames of {width}×{height} px", _FRAMES_KEPT * len(content))
    image = np.frombuffer(content, "<u2", offset=FRAME.size).reshape(height, width)
    return ApsFrame(start_us=start_us, end_us=end_us, image=image)
