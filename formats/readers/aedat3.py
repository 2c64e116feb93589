"""AEDAT 3.1, written by cAER: packets of one event type each, little-endian."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from formats.columns import EventColumns, FileHeader, ParsedFile, ParsedItem, ReadOptions, Size
from formats.errors import FormatError
from formats.readers.aedat_header import read_header

_PACKET_HEAD = struct.Struct("<hhiiiiii")
"""Type, source, size of an event, offset of its time, overflows, capacity, count, valid count."""
_POLARITY = 1
_POLARITY_BYTES = 8
_PACKET_MAX = 1 << 28
"""Largest plausible packet (assumed: those of cAER have a few kB) [bytes]."""

_SIZES: dict[str, Size] = {
    "DVS128": (128, 128),
    "EDVS": (128, 128),
    "DAVIS128": (128, 128),
    "DAVIS208": (208, 192),
    "DAVIS240": (240, 180),
    "DAVIS346": (346, 260),
    "DAVIS640": (640, 480),
}
"""Size of a sensor by the beginning of the source line in the header [px]."""


def read(path: Path, options: ReadOptions) -> ParsedFile:
    """Read contrast events; packets of other types are skipped."""
    del options
    header, start = read_header(path, last=b"#!END-HEADER")
    source = re.search(r"#Source \d+: *(\S+)", header)
    started = re.search(r"#Start-Time: *(.+)", header)
    name = source[1] if source else ""
    size = next((size for known, size in _SIZES.items() if name.upper().startswith(known)), None)
    facts = {"source": name} if name else {}
    facts |= {"start": started[1].strip()} if started else {}
    return FileHeader(size, facts), _items(path, start)


def _items(path: Path, start: int) -> Iterator[ParsedItem]:
    length, at = path.stat().st_size, start
    with path.open("rb") as file:
        file.seek(start)
        while at < length:
            kind, _, size, _, overflow, capacity, number, _ = _packet_head(path, file, at, length)
            body = at + _PACKET_HEAD.size
            at = body + size * capacity
            if kind == _POLARITY:
                if size != _POLARITY_BYTES:
                    raise _damaged_packet(path, body - _PACKET_HEAD.size)
                words = np.frombuffer(file.read(size * number), "<u4").reshape(-1, 2)
                yield _columns(words, overflow)
            file.seek(at)


def _packet_head(path: Path, file: BinaryIO, at: int, length: int) -> tuple[int, ...]:
    head = file.read(_PACKET_HEAD.size)
    if len(head) < _PACKET_HEAD.size:
        raise _damaged_packet(path, at)
    fields = _PACKET_HEAD.unpack(head)
    _, _, size, _, overflow, capacity, number, _ = fields
    plausible = size > 0 and 0 <= number <= capacity and 0 <= overflow < 1 << 20
    body = size * capacity
    if not plausible or body > _PACKET_MAX or at + _PACKET_HEAD.size + body > length:
        raise _damaged_packet(path, at)
    return fields


def _columns(
    words: np.ndarray[tuple[int, ...], np.dtype[np.uint32]], overflow: int
) -> EventColumns:
    words = words[(words[:, 0] & 1) == 1]
    data = words[:, 0].astype(np.int64)
    t = words[:, 1].astype(np.int64) + (overflow << 31)
    return EventColumns(t, (data >> 17) & 0x7FFF, (data >> 2) & 0x7FFF, ((data >> 1) & 1) == 1)


def _damaged_packet(path: Path, at: int) -> FormatError:
    return FormatError(
        f"{path} is truncated or damaged in the packet at byte {at}. The events before that were "
        f"read. Remove the rest with: head -c {at}"
    )
