"""AEDAT 3.1, of cAER: packets of events of one type each, little-endian."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from formats.columns import Columns, Head, Item, Options, Reading, Size
from formats.errors import FormatError
from formats.readers.aedat_header import read_header

_PACKET_HEAD = struct.Struct("<hhiiiiii")
"""Type, source, size of an event, offset of its time, overflows, capacity, number, valid."""
_POLARITY = 1
_POLARITY_BYTES = 8
_PACKET_MAX = 1 << 28
"""Longest packet that is believed (assumed: cAER's have a few kB) [bytes]."""

_SIZES: dict[str, Size] = {
    "DVS128": (128, 128),
    "EDVS": (128, 128),
    "DAVIS128": (128, 128),
    "DAVIS208": (208, 192),
    "DAVIS240": (240, 180),
    "DAVIS346": (346, 260),
    "DAVIS640": (640, 480),
}
"""Sensors by how the header's source line begins [px]."""


def read(path: Path, options: Options) -> Reading:
    """Events of contrast; packets of other types are left out."""
    del options
    header, start = read_header(path, last=b"#!END-HEADER")
    source = re.search(r"#Source \d+: *(\S+)", header)
    began = re.search(r"#Start-Time: *(.+)", header)
    name = source[1] if source else ""
    size = next((size for known, size in _SIZES.items() if name.upper().startswith(known)), None)
    says = {"source": name} if name else {}
    says |= {"start": began[1].strip()} if began else {}
    return Head(size, says), _items(path, start)


def _items(path: Path, start: int) -> Iterator[Item]:
    length, at = path.stat().st_size, start
    with path.open("rb") as file:
        file.seek(start)
        while at < length:
            kind, _, size, _, overflow, capacity, number, _ = _packet_head(path, file, at, length)
            body = at + _PACKET_HEAD.size
            at = body + size * capacity
            if kind == _POLARITY:
                if size != _POLARITY_BYTES:
                    raise _broken(path, body - _PACKET_HEAD.size)
                words = np.frombuffer(file.read(size * number), "<u4").reshape(-1, 2)
                yield _columns(words, overflow)
            file.seek(at)


def _packet_head(path: Path, file: BinaryIO, at: int, length: int) -> tuple[int, ...]:
    head = file.read(_PACKET_HEAD.size)
    if len(head) < _PACKET_HEAD.size:
        raise _broken(path, at)
    fields = _PACKET_HEAD.unpack(head)
    _, _, size, _, overflow, capacity, number, _ = fields
    sound = size > 0 and 0 <= number <= capacity and 0 <= overflow < 1 << 20
    bytes_ = size * capacity
    if not sound or bytes_ > _PACKET_MAX or at + _PACKET_HEAD.size + bytes_ > length:
        raise _broken(path, at)
    return fields


def _columns(words: np.ndarray[tuple[int, ...], np.dtype[np.uint32]], overflow: int) -> Columns:
    words = words[(words[:, 0] & 1) == 1]
    data = words[:, 0].astype(np.int64)
    t = words[:, 1].astype(np.int64) + (overflow << 31)
    return Columns(t, (data >> 17) & 0x7FFF, (data >> 2) & 0x7FFF, ((data >> 1) & 1) == 1)


def _broken(path: Path, at: int) -> FormatError:
    return FormatError(
        f"{path} is cut or damaged in the packet at byte {at}; what comes before was read; keep "
        f"that with: head -c {at}"
    )
