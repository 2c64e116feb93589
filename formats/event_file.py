"""Reading: one function for every format."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np

from emulator import ApsFrame
from flybench.events import EVENT_DTYPE, Events, empty_events, joined
from formats.columns import SIDE_MAX, UNITS_US, Options
from formats.errors import FormatError
from formats.identify import FORMATS, check_file, format_of
from formats.isolated_reader import Guard
from formats.parser_process import FRAME

_FRAMES_PENDING = 32
"""Frames that wait for events which reach their end (assumed)."""


@dataclass(frozen=True, eq=False)
class Chunk:
    """A piece of a recording.

    Attributes:
        events: sorted, not older than those of the chunk before; may be empty.
        frames: whose exposure ended with these events or before.
    """

    events: Events
    frames: tuple[ApsFrame, ...] = ()


@dataclass(frozen=True)
class Found:
    """What was in the part of a file that has been read.

    Attributes:
        events: how many.
        on: how many of them ON.
        frames: how many.
        first_us: time of the first event [µs].
        last_us: time of the last event [µs].
        x_min: leftmost column with an event [px].
        x_max: rightmost column [px].
        y_min: uppermost row [px].
        y_max: lowest row [px].
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
        """From the first event to the last [µs]."""
        return self.last_us - self.first_us

    @property
    def rate_hz(self) -> float:
        """Events a second; 0 where no time passed."""
        return self.events / self.span_us * 1e6 if self.span_us else 0.0

    @property
    def on_share(self) -> float:
        """Share of ON events, 0 to 1; 0 where there is none."""
        return self.on / self.events if self.events else 0.0

    def with_chunk(self, chunk: Chunk) -> Found:
        """What was found when `chunk` is counted too."""
        events, frames = chunk.events, self.frames + len(chunk.frames)
        if not events.size:
            return Found(**{**self.__dict__, "frames": frames})
        x, y = events["x"], events["y"]
        low = (int(x.min()), int(y.min()))
        high = (int(x.max()), int(y.max()))
        if self.events:
            low = (min(low[0], self.x_min), min(low[1], self.y_min))
            high = (max(high[0], self.x_max), max(high[1], self.y_max))
        return Found(
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
    """An open recording: iterate over it, once, for its chunks. Use as a context manager.

    Attributes:
        path: the file.
        format: one of `FORMATS`.
        width: sensor columns [px].
        height: sensor rows [px].
        size_from: what told the size: "the file", "the option" or "the events".
        has_frames: whether the file says that it holds frames.
        what_it_says: other facts from its header, by what they are called there.
        origin_us: what was taken from the file's own times [µs]: the first time, where that is a
            wall clock's (later than 10¹⁴ µs) or before 0; else 0.
    """

    def __init__(self, path: Path, name: str, options: Options) -> None:
        """Begin to read; `open_events` does so after its checks."""
        self.path = path
        self.format = name
        self._found = Found()
        self._ended = False
        self._guard = Guard(path, name, options)
        self._messages = self._guard.messages()
        try:
            _, head = next(self._messages)
            facts: dict[str, Any] = json.loads(head.decode())
        except BaseException:
            self._guard.close()
            raise
        self.width, self.height = facts["size"]
        self.size_from: str = facts["size_from"]
        self.has_frames: bool = facts["has_frames"]
        self.what_it_says: dict[str, str] = facts["says"]
        self.origin_us: int = facts["origin_us"]

    def __enter__(self) -> EventFile:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the file."""
        self._guard.close()

    @property
    def found(self) -> Found:
        """What was in the chunks so far."""
        return self._found

    def __iter__(self) -> Iterator[Chunk]:
        """The chunks, in constant memory.

        Raises:
            FormatError: the file is cut, damaged or unsound; what came before was given. Or it has
                been read to its end.
        """
        if self._ended:
            raise FormatError(f"{self.path} has been read to its end; open it again")
        pending: list[ApsFrame] = []
        for kind, content in self._messages:
            if kind == b"F":
                pending.append(_frame(content))
                if len(pending) > _FRAMES_PENDING:
                    yield self._counted(Chunk(empty_events(), (pending.pop(0),)))
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
        self._found = self._found.with_chunk(chunk)
        return chunk


def open_events(
    path: Path | str,
    *,
    format: str | None = None,  # noqa: A002  (what it is called everywhere)
    size: tuple[int, int] | None = None,
    time_unit: str | None = None,
) -> EventFile:
    """Open a recording of any format, found by what the file begins with.

    Args:
        path: the file.
        format: one of `FORMATS`; None: look.
        size: sensor's width and height, where the file does not say or is wrong [px].
        time_unit: "s", "ms", "us" or "ns", where the file does not say or is wrong; only for text,
            HDF5 and NumPy, whose other default is s for times with decimals and µs for whole ones.

    Returns:
        The open file, with what it says of itself.

    Raises:
        FormatError: it cannot be read, and why; in one sentence.
        MissingLibraryError: a library is missing, with the command that installs it.
    """
    path = Path(path)
    if format is not None and format not in FORMATS:
        raise FormatError(f"the format is {format!r}; allowed is one of {', '.join(FORMATS)}")
    if time_unit is not None and time_unit not in UNITS_US:
        raise FormatError(f"the unit of time is {time_unit!r}; allowed is {', '.join(UNITS_US)}")
    if size is not None and not all(0 < side <= SIDE_MAX for side in size):
        raise FormatError(
            f"the sensor's size is {size[0]}x{size[1]}; allowed is 1 to {SIDE_MAX} px each way"
        )
    check_file(path)
    return EventFile(path, format or format_of(path), Options(size, time_unit))


def read_events(
    path: Path | str,
    *,
    format: str | None = None,  # noqa: A002
    size: tuple[int, int] | None = None,
    time_unit: str | None = None,
) -> Events:
    """All events of a file at once; for files that fit into memory. Arguments as `open_events`."""
    with open_events(path, format=format, size=size, time_unit=time_unit) as file:
        chunks = [chunk.events for chunk in file]
    return joined(chunks)


def _frame(content: bytearray) -> ApsFrame:
    start_us, end_us, width, height = FRAME.unpack_from(content)
    image = np.frombuffer(content, "<u2", offset=FRAME.size).reshape(height, width)
    return ApsFrame(start_us=start_us, end_us=end_us, image=image)


__all__ = ["Chunk", "EventFile", "FormatError", "Found", "open_events", "read_events"]
