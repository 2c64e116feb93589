"""AEDAT 2, written by jAER: a 32-bit address and a 32-bit timestamp per event, big-endian.

The meaning of the address bits depends on the chip and is taken from jAER's source. jAER counts x
from the right and y from the bottom of the image; this reader flips both.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from formats.columns import (
    Array,
    EventColumns,
    FileHeader,
    ParsedFile,
    ParsedItem,
    ReadOptions,
    Size,
)
from formats.errors import FormatError
from formats.readers.aedat_header import read_header

_RECORD = np.dtype([("address", ">u4"), ("t", ">u4")])
_BLOCK = 1 << 17


@dataclass(frozen=True)
class Chip:
    """Layout of the address bits of one chip.

    Attributes:
        size: columns and rows [px].
        x_shift: lowest bit of x.
        x_bits: number of bits of x.
        y_shift: lowest bit of y.
        y_bits: number of bits of y.
        p_bit: bit of the polarity.
        on: value of that bit for ON.
        other: mask of bits that are all zero in a contrast event.
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
"""Chips by a regular expression for the name of their class in jAER."""


_CREATED = re.compile(
    r"^# ?(?:creation date: |creation time: (?!system)|created (?=.*\d))(.+)", re.I | re.M
)
"""Line with the date: of jAER today, of v2e, and of jAER before 2013 and MATLAB scripts."""


def read(path: Path, options: ReadOptions) -> ParsedFile:
    """Read contrast events; frame samples and inertial (IMU) samples are skipped.

    Raises:
        FormatError: the chip is unknown.
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
            f"{path} does not state a known chip ({name or 'no AEChip line'}). State the size of "
            f"its sensor with --size. Allowed is one of {sizes}."
        )
    facts = {"chip": name} if name else {}
    created = _CREATED.search(header)
    facts |= {"created": created[1].strip()} if created else {}
    return FileHeader(chip.size, facts), _items(path, start, chip)


def _items(path: Path, start: int, chip: Chip) -> Iterator[ParsedItem]:
    wraps, last = 0, 0
    with path.open("rb") as file:
        file.seek(start)
        while block := file.read(_BLOCK * _RECORD.itemsize):
            count = len(block) // _RECORD.itemsize
            records = np.frombuffer(block, _RECORD, count=count)
            records = records[(records["address"] & chip.other) == 0]
            t, wraps, last = unwrap(records["t"].astype(np.int64), wraps, last)
            yield _columns(records["address"].astype(np.int64), t, chip)
            if len(block) % _RECORD.itemsize:
                at = path.stat().st_size
                raise FormatError(
                    f"{path} ends within an 8-byte event, at byte {at}. It was truncated; the "
                    "events before that were read. Remove the rest with: head -c "
                    f"{at - (at - start) % 8}"
                )


def unwrap(t: Array, wraps: int, last: int) -> tuple[Array, int, int]:
    """Extend 32-bit timestamps: a step back by more than half their range is a wrap-around.

    Args:
        t: timestamps.
        wraps: number of wrap-arounds before them.
        last: timestamp before them.

    Returns:
        Extended timestamps, wrap-arounds so far, and the last timestamp as stored.
    """
    if not t.size:
        return t, wraps, last
    wrapped = np.diff(t, prepend=last) < -(1 << 31)
    total = wraps + np.cumsum(wrapped)
    return t + (total << 32), int(total[-1]), int(t[-1])


def _columns(address: Array, t: Array, chip: Chip) -> EventColumns:
    x = (address >> chip.x_shift) & ((1 << chip.x_bits) - 1)
    y = (address >> chip.y_shift) & ((1 << chip.y_bits) - 1)
    on = ((address >> chip.p_bit) & 1) == chip.on
    return EventColumns(t, chip.size[0] - 1 - x, chip.size[1] - 1 - y, on)
