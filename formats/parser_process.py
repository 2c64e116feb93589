"""The process that parses a file, and the messages that it sends to `formats.isolated_reader`.

A message is a kind (1 byte), a length (8 bytes, little-endian) and that many bytes of content:

- `H`: header of the file, as a JSON object.
- `E`: events of `PARSED_DTYPE`.
- `F`: a frame: start, end, width and height (8 bytes each), then 2 bytes per pixel.
- `C`: what was counted while reading, as a JSON object; at the end of the file.
- `W`: still working; no content.
- `X`: an error message; no further messages follow.
- `Z`: end of the file.
"""

from __future__ import annotations

import json
import struct
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from formats.columns import (
    MAX_SIDE_PX,
    WALL_CLOCK_MIN_US,
    Array,
    FileHeader,
    ParsedFrame,
    ParsedItem,
    ReadOptions,
    Size,
    joined,
    to_events,
    valid_length,
)
from formats.errors import FormatError
from formats.event_order import TimeOrder
from formats.identify import FORMATS
from formats.readers import reader_of
from formats.sensor_size import infer_size
from formats.time_unit import TimeUnit, choose_unit, to_microseconds, unit_us

MESSAGE = struct.Struct("<cQ")
FRAME = struct.Struct("<4q")
MEMORY_LIMIT_BYTES = 1 << 30
"""Most memory that this process may allocate [bytes]."""

BATCH = 1 << 16
"""Events are collected until there are this many, then sent as one message."""

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
    stated = job["options"]
    size = tuple(stated["size"]) if stated["size"] else None
    options = ReadOptions(**stated | {"size": size})
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
    header, unit, items = _open(path, name, options)
    size = options.size or header.size
    source = "the option" if options.size else header.size_source
    if size is None:
        size, source = (
            infer_size(path, items, header.possible_sizes, lambda: _send(out, b"W")),
            "the events",
        )
        header, unit, items = _open(path, name, options)
    if not all(0 < side <= MAX_SIDE_PX for side in size):
        raise FormatError(
            f"{path} states a sensor of {size[0]}x{size[1]} px. Allowed is 1 to {MAX_SIDE_PX} px "
            "each way. Give the true size with --size."
        )
    order = TimeOrder(path, options)
    checked = _checked(path, items, size, order, size_is_option=options.size is not None)
    shifted, origin_us = _with_origin(checked)
    facts = {
        "size": size,
        "size_source": source,
        "facts": header.facts | {"time unit": str(unit)},
        "has_frames": header.has_frames,
        "origin_us": origin_us,
        "warnings": [unit.warning] if unit.warning else [],
    }
    _send(out, b"H", json.dumps(facts).encode())
    for item in _batched(shifted):
        if isinstance(item, ParsedFrame):
            height, width = item.image.shape
            numbers = FRAME.pack(item.start_us, item.end_us, width, height)
            _send(out, b"F", numbers, np.ascontiguousarray(item.image, "<u2").data.cast("B"))
        elif item.size:
            _send(out, b"E", item.view(np.uint8).data)
    counts = {
        "sorted_events": order.sorted if options.sort_within_us else None,
        "dropped_events": order.dropped if options.drop_unsorted else None,
    }
    _send(out, b"C", json.dumps(counts).encode())
    _send(out, b"Z")


def _open(
    path: Path, name: str, options: ReadOptions
) -> tuple[FileHeader, TimeUnit, Iterator[ParsedItem]]:
    """Return the header, the unit of the timestamps, and the items with times in µs."""
    header, items = reader_of(name)(path, options)
    head: list[ParsedItem] = []
    times = np.empty(0, np.int64)
    for item in items:
        head.append(item)
        if isinstance(item, ParsedFrame) or item.t.size:
            times = times if isinstance(item, ParsedFrame) else item.t
            break
    unit = choose_unit(
        times,
        option=options.time_unit,
        stated=header.time_unit,
        source=header.unit_source,
        path=path,
    )
    return header, unit, _in_microseconds(path, chain(head, items), unit.name)


def _in_microseconds(path: Path, items: Iterable[ParsedItem], unit: str) -> Iterator[ParsedItem]:
    factor = unit_us(unit)
    for item in items:
        if isinstance(item, ParsedFrame):
            start_us, end_us = round(item.start_us * factor), round(item.end_us * factor)
            yield ParsedFrame(start_us, end_us, item.image)
        else:
            yield replace(item, t=to_microseconds(item.t, unit, path=path))


def _with_origin(
    checked: Iterator[Array | ParsedFrame],
) -> tuple[Iterator[Array | ParsedFrame], int]:
    """Return checked events and frames in time from the origin, and the origin itself [µs]."""
    head: list[Array | ParsedFrame] = []
    for item in checked:
        head.append(item)
        if isinstance(item, ParsedFrame) or item.size:
            break
    first = head[-1] if head else None
    if isinstance(first, ParsedFrame):
        first_us = first.start_us
    else:
        first_us = int(first["t"][0]) if first is not None and first.size else 0
    origin_us = first_us if first_us < 0 or first_us >= WALL_CLOCK_MIN_US else 0
    return _shifted(head, checked, origin_us), origin_us


def _checked(
    path: Path,
    items: Iterator[ParsedItem],
    size: Size,
    order: TimeOrder,
    *,
    size_is_option: bool,
) -> Iterator[Array | ParsedFrame]:
    """Yield frames, and valid events in order of time; before an error, all events before it."""
    done = 0
    try:
        for item in items:
            if isinstance(item, ParsedFrame):
                yield item
                continue
            valid, error = valid_length(
                item, size, path=path, done=done, size_is_option=size_is_option
            )
            done += valid
            if valid:
                yield from order.push(to_events(item.first(valid)))
            if error is not None:
                raise error
    except GeneratorExit:
        raise
    except BaseException:
        yield from order.finish()
        raise
    yield from order.finish()


def _shifted(
    head: list[Array | ParsedFrame], rest: Iterator[Array | ParsedFrame], origin_us: int
) -> Iterator[Array | ParsedFrame]:
    for source in (head, rest):
        for item in source:
            if isinstance(item, ParsedFrame):
                if item.start_us >= origin_us and item.end_us >= item.start_us:
                    start_us, end_us = item.start_us - origin_us, item.end_us - origin_us
                    yield ParsedFrame(start_us, end_us, item.image)
                continue
            item["t"] -= origin_us
            yield item


def _batched(items: Iterator[Array | ParsedFrame]) -> Iterator[Array | ParsedFrame]:
    """Yield frames, and events in arrays of `BATCH` or more; before an error, those collected."""
    pending: list[Array] = []
    count = 0
    try:
        for item in items:
            if isinstance(item, ParsedFrame):
                yield item
                continue
            pending.append(item)
            count += item.size
            if count >= BATCH:
                yield joined(pending)
                pending, count = [], 0
    except BaseException:
        if pending:
            yield joined(pending)
        raise
    if pending:
        yield joined(pending)
