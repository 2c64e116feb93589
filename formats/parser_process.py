"""The process that parses a file, and what it says to the one that asked.

A message is a kind (one byte), a length (8 bytes, little-endian) and that many bytes. `H`: a JSON
object with what the file says. `E`: events of `RAW_DTYPE`. `F`: a frame, as start, end, width and
height (8 bytes each) and pixels of 2 bytes. `W`: still at work. `X`: why it cannot go on. `Z`: the
end.
"""

from __future__ import annotations

import json
import struct
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from formats.columns import (
    CLOCK_US,
    SIDE_MAX,
    Array,
    Columns,
    Item,
    Options,
    RawFrame,
    Size,
    check_order,
    pack,
)
from formats.errors import FormatError
from formats.identify import FORMATS
from formats.readers import reader_of

MESSAGE = struct.Struct("<cQ")
FRAME = struct.Struct("<4q")
MEMORY_BYTES = 1 << 30
"""Memory that this process may have."""

BATCH = 1 << 16
"""Events from which on a message is sent."""

_SENSORS: tuple[Size, ...] = (
    (128, 128),
    (240, 180),
    (304, 240),
    (320, 320),
    (346, 260),
    (640, 480),
    (1280, 720),
)
"""Sizes of the sensors that are sold [px]."""


def main() -> None:
    """Parse the file that the first argument, a JSON object, names; write to standard output."""
    job = json.loads(sys.argv[1])
    limit_memory()
    out = sys.stdout.buffer
    path, name = Path(job["path"]), job["format"]
    answer(path, name, Options(tuple(job["size"]) if job["size"] else None, job["time_unit"]), out)


def answer(path: Path, name: str, options: Options, out: BinaryIO) -> None:
    """Parse a file and send all of it, or as much as can be read and why no more."""
    try:
        serve(path, name, options, out)
    except FormatError as error:
        send(out, b"X", str(error).encode())
    except BrokenPipeError:
        return
    except MemoryError:
        send(out, b"X", f"{path} {TOO_LARGE}".encode())
    except BaseException as error:  # a library's own, and a panic of one in Rust
        text = str(error).splitlines()[0] if str(error) else type(error).__name__
        send(out, b"X", f"{path} cannot be read as {FORMATS[name]}: {text}; {DAMAGED}".encode())


_TOO_LARGE = f"asks for more than {MEMORY_BYTES >> 30} GB of memory to be read"
_REPAIR = "; it is damaged, or packed in pieces too large; copy it again, or convert it"
TOO_LARGE = _TOO_LARGE + _REPAIR
TOO_LARGE_OR_LOST = f"{_TOO_LARGE}, or its reader gave up{_REPAIR}"
DAMAGED = "it is cut or damaged, or of another format; copy it again, or name it with --format"


def limit_memory() -> None:
    """Let this process have no more than `MEMORY_BYTES`, where the system can do that."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_BYTES, MEMORY_BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def send(out: BinaryIO, kind: bytes, *parts: Any) -> None:
    """Write one message."""
    out.write(MESSAGE.pack(kind, sum(memoryview(part).nbytes for part in parts)))
    for part in parts:
        out.write(part)
    out.flush()


def serve(path: Path, name: str, options: Options, out: BinaryIO) -> None:
    """Parse a file and send all of it."""
    read = reader_of(name)
    head, items = read(path, options)
    size, source = options.size or head.size, "the option" if options.size else "the file"
    if size is None:
        size, source = extent(path, items, out), "the events"
        head, items = read(path, options)
    if not all(0 < side <= SIDE_MAX for side in size):
        raise FormatError(
            f"{path} says that its sensor has {size[0]}x{size[1]} px; allowed is 1 to {SIDE_MAX}; "
            "give the true size with --size"
        )
    first, origin_us = normalised(path, items, size)
    says = {"size": size, "size_from": source, "says": head.says, "has_frames": head.has_frames}
    send(out, b"H", json.dumps(says | {"origin_us": origin_us}).encode())
    for item in batched(first):
        if isinstance(item, RawFrame):
            height, width = item.image.shape
            numbers = FRAME.pack(item.start_us, item.end_us, width, height)
            send(out, b"F", numbers, np.ascontiguousarray(item.image, "<u2").data.cast("B"))
        elif item.size:
            send(out, b"E", item.view(np.uint8).data)
    send(out, b"Z")


def extent(path: Path, items: Iterator[Item], out: BinaryIO) -> Size:
    """The smallest sensor on sale that the events nearly fill, or as far as they reach [px]."""
    width = height = 0
    done = 0
    try:
        for item in items:
            send(out, b"W")
            if isinstance(item, Columns) and item.t.size:
                pack(item, None, path=path, done=done)
                done += item.t.size
                width = max(width, int(item.x.max()) + 1)
                height = max(height, int(item.y.max()) + 1)
    except FormatError:  # the second pass gives what comes before, and says this again
        if not done:
            raise
    if not done:
        raise FormatError(f"{path} holds no events; give a recording with some, or --size")
    for columns, rows in _SENSORS:
        if 0.9 * columns <= width <= columns and 0.9 * rows <= height <= rows:
            return columns, rows
    return width, height


def normalised(
    path: Path, items: Iterator[Item], size: Size
) -> tuple[Iterator[Array | RawFrame], int]:
    """Sound events and frames, and what was taken from their times [µs]."""
    sound = _sound(path, items, size)
    head: list[Array | RawFrame] = []
    for item in sound:
        head.append(item)
        if isinstance(item, RawFrame) or item.size:
            break
    first = head[-1] if head else None
    if isinstance(first, RawFrame):
        first_us = first.start_us
    else:
        first_us = int(first["t"][0]) if first is not None and first.size else 0
    origin_us = first_us if first_us < 0 or first_us >= CLOCK_US else 0
    return _shifted(head, sound, origin_us), origin_us


def _sound(path: Path, items: Iterator[Item], size: Size) -> Iterator[Array | RawFrame]:
    done, last_us = 0, None
    for item in items:
        if isinstance(item, RawFrame):
            yield item
            continue
        events = pack(item, size, path=path, done=done)
        if events.size:
            check_order(events, last_us, path=path, done=done)
            last_us, done = int(events["t"][-1]), done + events.size
            yield events


def _shifted(
    head: list[Array | RawFrame], rest: Iterator[Array | RawFrame], origin_us: int
) -> Iterator[Array | RawFrame]:
    for source in (head, rest):
        for item in source:
            if isinstance(item, RawFrame):
                if item.start_us >= origin_us and item.end_us >= item.start_us:
                    yield RawFrame(item.start_us - origin_us, item.end_us - origin_us, item.image)
                continue
            item["t"] -= origin_us
            yield item


def batched(items: Iterator[Array | RawFrame]) -> Iterator[Array | RawFrame]:
    """Events in pieces of `BATCH` or more; what is pending is sent before an error."""
    pending: list[Array] = []
    count = 0
    try:
        for item in items:
            if isinstance(item, RawFrame):
                yield item
                continue
            pending.append(item)
            count += item.size
            if count >= BATCH:
                yield np.concatenate(pending)
                pending, count = [], 0
    except BaseException:
        if pending:
            yield np.concatenate(pending)
        raise
    if pending:
        yield np.concatenate(pending)
