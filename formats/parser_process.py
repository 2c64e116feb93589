"""The process that parses a file, and the messages that it sends to `formats.isolated_reader`.

A message is a kind (1 byte), a length (8 bytes, little-endian) and that many bytes of content:

- `H`: header of the file, as a JSON object.
- `E`: events of `PARSED_DTYPE`.
- `F`: a frame: start, end, width and height (8 bytes each), then 2 bytes per pixel.
- `I`: IMU samples of `formats.samples.IMU_DTYPE`.
- `T`: triggers of `formats.samples.TRIGGER_DTYPE`.
- `W`: still working; no content.
- `X`: an error message; no further messages follow.
- `Z`: end of the file.
"""

from __future__ import annotations

import json
import struct
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import numpy as np

from formats.bytes_read import bytes_read
from formats.columns import (
    MAX_SIDE_PX,
    WALL_CLOCK_MIN_US,
    Array,
    EventColumns,
    ParsedFrame,
    ParsedItem,
    ReadOptions,
    Size,
    check_time_order,
    to_events,
)
from formats.errors import FormatError
from formats.identify import FORMATS
from formats.readers import reader_of
from formats.samples import IMU_DTYPE, ParsedSamples

ParsedArray: TypeAlias = Array | ParsedFrame | ParsedSamples
"""Checked content of a file; an array holds events of `PARSED_DTYPE`."""

MESSAGE = struct.Struct("<cQ")
FRAME = struct.Struct("<4q")
MEMORY_LIMIT_BYTES = 1 << 30
"""Most memory that this process may allocate [bytes]."""

BATCH = 1 << 16
"""Events are collected until there are this many, then sent as one message."""

_SENSOR_SIZES: tuple[Size, ...] = (
    (128, 128),
    (240, 180),
    (304, 240),
    (320, 320),
    (346, 260),
    (640, 480),
    (1280, 720),
)
"""Width and height of common sensors [px]."""

_TOO_LARGE = f"needs more than {MEMORY_LIMIT_BYTES >> 30} GB of memory to be read"
_REPAIR = "It is damaged, or compressed in blocks that are too large. Copy it again or convert it."
TOO_LARGE = f"{_TOO_LARGE}. {_REPAIR}"
TOO_LARGE_OR_ABORTED = f"{_TOO_LARGE}, or its parser aborted. {_REPAIR}"
DAMAGED = (
    "It is truncated, damaged or of another format. Copy it again, or name its format with "
    "--format."
)


def main() -> None:
    """Parse the file that the first argument, a JSON object, names; write to standard output."""
    job = json.loads(sys.argv[1])
    limit_memory()
    size = tuple(job["size"]) if job["size"] else None
    options = ReadOptions(size, job["time_unit"])
    parse(Path(job["path"]), job["format"], options, sys.stdout.buffer)


def parse(path: Path, name: str, options: ReadOptions, out: BinaryIO) -> None:
    """Parse a file and send its content, or the content before an error and then the error.

    Args:
        path: path of the file.
        name: name of its format, one of `FORMATS`.
        options: what the user states about the file.
        out: stream to write messages to.
    """
    try:
        _send_file(path, name, options, out)
    except FormatError as error:
        _send(out, b"X", str(error).encode())
    except BrokenPipeError:
        return
    except MemoryError:
        _send(out, b"X", f"{path} {TOO_LARGE}".encode())
    except BaseException as error:  # errors of decoding libraries, and panics in Rust
        text = str(error).splitlines()[0] if str(error) else type(error).__name__
        _send(out, b"X", f"{path} cannot be read as {FORMATS[name]}: {text}. {DAMAGED}".encode())


def limit_memory() -> None:
    """Limit the memory of this process to `MEMORY_LIMIT_BYTES` on systems that support it."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_LIMIT_BYTES, MEMORY_LIMIT_BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _send(out: BinaryIO, kind: bytes, *parts: Any) -> None:
    """Write one message."""
    out.write(MESSAGE.pack(kind, sum(memoryview(part).nbytes for part in parts)))
    for part in parts:
        out.write(part)
    out.flush()


def _send_file(path: Path, name: str, options: ReadOptions, out: BinaryIO) -> None:
    read, read_before = reader_of(name), bytes_read()
    header, items = read(path, options)
    size, source = options.size or header.size, "the option" if options.size else "the file"
    if size is None:
        size, source = infer_size(path, items, out), "the events"
        read_before = bytes_read()
        header, items = read(path, options)
    if not all(0 < side <= MAX_SIDE_PX for side in size):
        raise FormatError(
            f"{path} states a sensor of {size[0]}x{size[1]} px. Allowed is 1 to {MAX_SIDE_PX} px "
            "each way. Give the true size with --size."
        )
    shifted, origin_us = _with_origin(path, items, size)
    facts = {
        "size": size,
        "size_source": source,
        "facts": header.facts,
        "has_frames": header.has_frames,
        "origin_us": origin_us,
        "read_before": read_before,
    }
    _send(out, b"H", json.dumps(facts).encode())
    for item in _batched(shifted):
        if isinstance(item, ParsedFrame):
            height, width = item.image.shape
            numbers = FRAME.pack(item.start_us, item.end_us, width, height)
            _send(out, b"F", numbers, np.ascontiguousarray(item.image, "<u2").data.cast("B"))
        elif isinstance(item, ParsedSamples):
            kind = b"I" if item.samples.dtype == IMU_DTYPE else b"T"
            _send(out, kind, np.ascontiguousarray(item.samples).view(np.uint8).data)
        elif item.size:
            _send(out, b"E", item.view(np.uint8).data)
    _send(out, b"Z")


def infer_size(path: Path, items: Iterator[ParsedItem], out: BinaryIO) -> Size:
    """Return the size of the sensor from the extent of the events [px].

    The result is the smallest common sensor of which the events span at least 90 % each way, or
    their extent if there is none.
    """
    width = height = 0
    done = 0
    try:
        for item in items:
            _send(out, b"W")
            if isinstance(item, EventColumns) and item.t.size:
                to_events(item, None, path=path, done=done)
                done += item.t.size
                width = max(width, int(item.x.max()) + 1)
                height = max(height, int(item.y.max()) + 1)
    except FormatError:  # the second pass sends the events before the error, and raises it again
        if not done:
            raise
    if not done:
        raise FormatError(
            f"{path} contains no events, so the size of its sensor is unknown. Allowed is a "
            "recording with events, or a stated size. Give the size with --size."
        )
    for columns, rows in _SENSOR_SIZES:
        if 0.9 * columns <= width <= columns and 0.9 * rows <= height <= rows:
            return columns, rows
    return width, height


def _with_origin(
    path: Path, items: Iterator[ParsedItem], size: Size
) -> tuple[Iterator[ParsedArray], int]:
    """Return checked events and frames in time from the origin, and the origin itself [µs]."""
    checked = _checked(path, items, size)
    head: list[ParsedArray] = []
    for item in checked:
        head.append(item)
        if isinstance(item, ParsedFrame) or (isinstance(item, np.ndarray) and item.size):
            break
    first, first_us = head[-1] if head else None, 0
    if isinstance(first, ParsedFrame):
        first_us = first.start_us
    elif isinstance(first, np.ndarray) and first.size:
        first_us = int(first["t"][0])
    origin_us = first_us if first_us < 0 or first_us >= WALL_CLOCK_MIN_US else 0
    return _shifted(head, checked, origin_us), origin_us


def _checked(path: Path, items: Iterator[ParsedItem], size: Size) -> Iterator[ParsedArray]:
    done, last_us = 0, None
    for item in items:
        if isinstance(item, ParsedFrame | ParsedSamples):
            yield item
            continue
        events = to_events(item, size, path=path, done=done)
        if events.size:
            check_time_order(events, last_us, path=path, done=done)
            last_us, done = int(events["t"][-1]), done + events.size
            yield events


def _shifted(
    head: list[ParsedArray], rest: Iterator[ParsedArray], origin_us: int
) -> Iterator[ParsedArray]:
    for source in (head, rest):
        for item in source:
            if isinstance(item, ParsedFrame):
                if item.start_us >= origin_us and item.end_us >= item.start_us:
                    start_us, end_us = item.start_us - origin_us, item.end_us - origin_us
                    yield ParsedFrame(start_us, end_us, item.image)
                continue
            times = item.samples if isinstance(item, ParsedSamples) else item
            times["t"] -= origin_us
            yield item


def _batched(items: Iterator[ParsedArray]) -> Iterator[ParsedArray]:
    """Yield frames, and events in arrays of `BATCH` or more; before an error, those collected."""
    pending: list[Array] = []
    count = 0
    try:
        for item in items:
            if isinstance(item, ParsedFrame | ParsedSamples):
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
