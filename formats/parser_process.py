"""The process that parses a file, and the messages that it sends to `formats.isolated_reader`.

A message is a kind (1 byte), a length (8 bytes, little-endian) and that many bytes of content:

- `H`: header of the file, as a JSON object.
- `E`: events of `PARSED_DTYPE`.
- `F`: a frame: start, end, width and height (8 bytes each), then 2 bytes per pixel.
- `I`: IMU samples of `formats.samples.IMU_DTYPE`.
- `T`: triggers of `formats.samples.TRIGGER_DTYPE`.
- `C`: what was counted while reading, as a JSON object; at the end, or before an error.
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

from formats.bytes_read import bytes_read
from formats.columns import (
    MAX_SIDE_PX,
    WALL_CLOCK_MIN_US,
    Array,
    EventColumns,
    FileHeader,
    ParsedArray,
    ParsedFrame,
    ParsedItem,
    ReadOptions,
    joined,
)
from formats.errors import FormatError
from formats.event_order import TimeOrder, valid_in_order
from formats.identify import FORMATS
from formats.readers import reader_of
from formats.samples import IMU_DTYPE, ParsedSamples
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
    read_before = bytes_read()
    header, unit, items = _open(path, name, options)
    size = options.size or header.size
    source = "the option" if options.size else header.size_source
    if size is None:
        size, source = (
            infer_size(path, items, header.possible_sizes, lambda: _send(out, b"W")),
            "the events",
        )
        read_before = bytes_read()
        header, unit, items = _open(path, name, options)
    if not all(0 < side <= MAX_SIDE_PX for side in size):
        raise FormatError(
            f"{path} states a sensor of {size[0]}x{size[1]} px. Allowed is 1 to {MAX_SIDE_PX} px "
            "each way. Give the true size with --size."
        )
    order = TimeOrder(path, options)
    checked = valid_in_order(path, items, size, order, size_is_option=options.size is not None)
    shifted, origin_us = _with_origin(checked)
    facts = {
        "size": size,
        "size_source": source,
        "facts": header.facts | {"time unit": str(unit)},
        "has_frames": header.has_frames,
        "origin_us": origin_us,
        "read_before": read_before,
        "warnings": [unit.warning] if unit.warning else [],
    }
    _send(out, b"H", json.dumps(facts).encode())
    try:
        for item in _batched(shifted):
            _send_item(out, item)
    finally:  # also before an error
        counts = {
            "sorted_events": order.sorted if options.sort_within_us else None,
            "dropped_events": order.dropped if options.drop_unsorted else None,
        }
        _send(out, b"C", json.dumps(counts).encode())
    _send(out, b"Z")


def _send_item(out: BinaryIO, item: ParsedArray) -> None:
    if isinstance(item, ParsedFrame):
        height, width = item.image.shape
        numbers = FRAME.pack(item.start_us, item.end_us, width, height)
        _send(out, b"F", numbers, np.ascontiguousarray(item.image, "<u2").data.cast("B"))
    elif isinstance(item, ParsedSamples):
        kind = b"I" if item.samples.dtype == IMU_DTYPE else b"T"
        _send(out, kind, np.ascontiguousarray(item.samples).view(np.uint8).data)
    elif item.size:
        _send(out, b"E", item.view(np.uint8).data)


def _open(
    path: Path, name: str, options: ReadOptions
) -> tuple[FileHeader, TimeUnit, Iterator[ParsedItem]]:
    """Return the header, the unit of the timestamps, and the items with times in µs."""
    header, items = reader_of(name)(path, options)
    head: list[ParsedItem] = []
    times = np.empty(0, np.int64)
    for item in items:
        head.append(item)
        if isinstance(item, ParsedFrame):
            break
        if isinstance(item, EventColumns) and item.t.size:
            times = item.t
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
        elif isinstance(item, ParsedSamples):
            item.samples["t"] = to_microseconds(item.samples["t"], unit, path=path)
            yield item
        else:
            yield replace(item, t=to_microseconds(item.t, unit, path=path))


def _with_origin(
    checked: Iterator[ParsedArray],
) -> tuple[Iterator[ParsedArray], int]:
    """Return checked events and frames in time from the origin, and the origin itself [µs]."""
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
    """Yield frames, and the events between them in arrays of up to `BATCH`, or a block more.

    Samples may come before the events that are collected. Before an error, those are yielded.
    """
    pending: list[Array] = []
    count = 0
    try:
        for item in items:
            if isinstance(item, np.ndarray):
                pending.append(item)
                count += item.size
            if pending and (isinstance(item, ParsedFrame) or count >= BATCH):
                yield joined(pending)
                pending, count = [], 0
            if not isinstance(item, np.ndarray):
                yield item
    except BaseException:
        if pending:
            yield joined(pending)
        raise
    if pending:
        yield joined(pending)
