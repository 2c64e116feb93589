"""AEDAT 2, of jAER: an address and a time of 32 bits an event, big-endian.

The address is the chip's. jAER itself is what its bits are taken from: it counts x from the
right of the address and y from the bottom of the picture, so both are turned round here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from formats.columns import Array, Columns, Head, Item, Options, Reading, Size
from formats.errors import FormatError
from formats.readers.aedat_header import read_header

_RECORD = np.dtype([("address", ">u4"), ("t", ">u4")])
_BLOCK = 1 << 17


@dataclass(frozen=True)
class Chip:
    """Where an address holds what.

    Attributes:
        size: columns and rows [px].
        x_shift: lowest bit of x.
        x_bits: bits of x.
        y_shift: lowest bit of y.
        y_bits: bits of y.
        p_bit: the bit of polarity.
        on: value of that bit for ON.
        other: bits that are all zero in an event of contrast.
    """

    size: Size
    x_shift: int = 12
    x_bits: int = 10
    y_shift: int = 22
    y_bits: int = 9
    p_bit: int = 11
    on: int = 1
    other: int = 0x8000_0400


_CHIPS = {
    r"DVS128|Tmpdiff128": Chip((128, 128), 1, 7, 8, 7, 0, 0, 0x8000_8000),
    r"Davis240|SBret10|SeeBetter": Chip((240, 180)),
    r"Davis346": Chip((346, 260)),
    r"Davis128": Chip((128, 128)),
    r"Davis208": Chip((208, 192)),
    r"Davis640": Chip((640, 480)),
}
"""Chips by what jAER calls their class."""


def read(path: Path, options: Options) -> Reading:
    """Events of contrast; samples of frames and of motion sensors are left out.

    Raises:
        FormatError: the header names no chip that is known.
    """
    header, start = read_header(path)
    named = re.search(r"AEChip:\s*(\S+)", header)
    name = named[1].rsplit(".", 1)[-1] if named else ""
    chip = next((chip for known, chip in _CHIPS.items() if re.match(known, name, re.I)), None)
    if chip is None:
        chip = next((chip for chip in _CHIPS.values() if chip.size == options.size), None)
    if chip is None:
        sizes = ", ".join(f"{w}x{h}" for w, h in sorted({c.size for c in _CHIPS.values()}))
        raise FormatError(
            f"{path} does not say which chip its addresses are of ({name or 'no AEChip line'}); "
            f"name its sensor with --size, one of {sizes}"
        )
    says = {"chip": name} if name else {}
    created = re.search(r"created (.+)", header)
    says |= {"created": created[1].strip()} if created else {}
    return Head(chip.size, says), _items(path, start, chip)


def _items(path: Path, start: int, chip: Chip) -> Iterator[Item]:
    wraps, last = 0, 0
    with path.open("rb") as file:
        file.seek(start)
        while block := file.read(_BLOCK * _RECORD.itemsize):
            whole = len(block) // _RECORD.itemsize
            records = np.frombuffer(block, _RECORD, count=whole)
            records = records[(records["address"] & chip.other) == 0]
            t, wraps, last = _unwrap(records["t"].astype(np.int64), wraps, last)
            yield _columns(records["address"].astype(np.int64), t, chip)
            if len(block) % _RECORD.itemsize:
                at = path.stat().st_size
                raise FormatError(
                    f"{path} ends within an event of 8 bytes, at byte {at}; it was cut; what "
                    f"comes before was read; keep that with: head -c {at - (at - start) % 8}"
                )


def _unwrap(t: Array, wraps: int, last: int) -> tuple[Array, int, int]:
    """Times of 32 bits as times that go on, where they jump back by more than half of all."""
    if not t.size:
        return t, wraps, last
    steps = np.diff(t, prepend=last) < -(1 << 31)
    turns = wraps + np.cumsum(steps)
    return t + (turns << 32), int(turns[-1]), int(t[-1])


def _columns(address: Array, t: Array, chip: Chip) -> Columns:
    x = (address >> chip.x_shift) & ((1 << chip.x_bits) - 1)
    y = (address >> chip.y_shift) & ((1 << chip.y_bits) - 1)
    on = ((address >> chip.p_bit) & 1) == chip.on
    return Columns(t, chip.size[0] - 1 - x, chip.size[1] - 1 - y, on)
