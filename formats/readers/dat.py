"""Prophesee DAT: a header, two bytes with the type and size of an event, and 8 bytes an event.

flybench has its own decoder because faery 0.7.1 gives a late event the time of the one before it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from formats.columns import Array, EventColumns, ParsedFile, ParsedItem, ReadOptions
from formats.errors import FormatError
from formats.readers.aedat2 import unwrap
from formats.readers.prophesee import file_header, percent_facts, read_words, shown_facts

_RECORD = np.dtype([("t", "<u4"), ("address", "<u4")])
_CD = (0x00, 0x0C)
"""Types of contrast-detection events."""

_BITS = {True: (14, 14), False: (9, 8)}
"""Bits of x and y by whether the version is 2 or later."""


def read(path: Path, options: ReadOptions) -> ParsedFile:
    """Read contrast-detection (CD) events.

    Raises:
        FormatError: the events have another type or size.
    """
    del options
    facts, start = percent_facts(path)
    with path.open("rb") as file:
        file.seek(start)
        kind, size = (*file.read(2), -1, -1)[:2]
    if kind not in _CD or size != _RECORD.itemsize:
        raise FormatError(
            f"{path} contains events of the type {kind} with {size} bytes. Allowed is CD (contrast "
            "detection), types 0 and 12, with 8 bytes. Give the file of CD events."
        )
    bits = _BITS[facts.get("version", "2").strip() not in ("0", "1")]
    return file_header(facts, shown_facts(facts)), _items(path, start + 2, bits)


def _items(path: Path, start: int, bits: tuple[int, int]) -> Iterator[ParsedItem]:
    wraps, last = 0, 0
    for records in read_words(path, start, _RECORD):
        t, wraps, last = unwrap(records["t"].astype(np.int64), wraps, last)
        address: Array = records["address"].astype(np.int64)
        x, y = address & ((1 << bits[0]) - 1), (address >> bits[0]) & ((1 << bits[1]) - 1)
        on = ((address >> (28 if bits[0] == 14 else 17)) & 0xF) > 0
        yield EventColumns(t, x, y, on)
