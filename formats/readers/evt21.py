"""Prophesee RAW, EVT 2.1: 64-bit words, each with up to 32 events of one row.

flybench has its own decoder because faery 0.7.1 does not accept the header `% format EVT21`. Files
of the IMX636 store the two halves of a word in the opposite order and state this as
`endianness=legacy`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from formats.columns import (
    Array,
    EventColumns,
    ParsedFile,
    ParsedItem,
    ReadOptions,
)
from formats.errors import FormatError
from formats.identify import percent_header
from formats.readers.prophesee import file_header

_OFF, _ON, _TIME_HIGH = 0, 1, 8
_KINDS = (_OFF, _ON, _TIME_HIGH, 0xA, 0xE, 0xF)
"""Valid types of words: the highest 4 bits."""

_BLOCK = 1 << 14
_HEADER_MAX = 1 << 20
_TIME_PERIOD = 1 << 28


def read(path: Path, options: ReadOptions) -> ParsedFile:
    """Read contrast events; triggers are skipped."""
    del options
    with path.open("rb") as file:
        facts, start = percent_header(file.read(_HEADER_MAX))
        file.seek(start)
        first = _words(file.read(8 * 1024))
    form = dict(
        part.split("=", 1) for part in facts.get("format", "").lower().split(";") if "=" in part
    )
    swapped = form.get("endianness") == "legacy"
    if not _has_valid_types(first, swapped) and _has_valid_types(first, not swapped):
        swapped = not swapped
    order = "swapped" if swapped else "in order"
    shown = {"format": facts.get("format", "EVT21"), "halves": order}
    return file_header(facts, shown), _items(path, start, swapped)


def _words(data: bytes) -> Array:
    return np.frombuffer(data, "<u8", count=len(data) // 8)


def _has_valid_types(words: Array, swapped: bool) -> bool:
    kinds = (words >> np.uint64(28 if swapped else 60)) & np.uint64(0xF)
    return bool(np.isin(kinds, _KINDS).all())


def _items(path: Path, start: int, swapped: bool) -> Iterator[ParsedItem]:
    high = 0
    with path.open("rb") as file:
        file.seek(start)
        while data := file.read(8 * _BLOCK):
            words = _words(data)
            if swapped:
                words = (words >> np.uint64(32)) | (words << np.uint64(32))
            columns, high = _decode(words, high)
            yield columns
            if len(data) % 8:
                at = path.stat().st_size
                raise FormatError(
                    f"{path} ends within an 8-byte word, at byte {at}. It was truncated; the "
                    "events before that were read. Remove the rest with: head -c "
                    f"{at - len(data) % 8}"
                )


def _decode(words: Array, high: int) -> tuple[EventColumns, int]:
    """Return the events in a block of words, and the high part of the time after it."""
    kinds = (words >> np.uint64(60)).astype(np.int64)
    highs = ((words >> np.uint64(32)) & np.uint64(_TIME_PERIOD - 1)).astype(np.int64)
    now, high = high_times(kinds, highs, high)
    chosen = np.flatnonzero((kinds == _OFF) | (kinds == _ON))
    word = words[chosen]
    valid = np.unpackbits(
        (word & np.uint64(0xFFFF_FFFF)).astype("<u4").view(np.uint8).reshape(-1, 4),
        axis=1,
        bitorder="little",
    )
    at, bit = np.nonzero(valid)
    fields = (word >> np.uint64(32)).astype(np.int64)
    t = (now[chosen] << 6) | ((fields >> 22) & 0x3F)
    x = ((fields >> 11) & 0x7FF)[at] + bit
    return EventColumns(t[at], x, (fields & 0x7FF)[at], kinds[chosen][at] == _ON), high


def high_times(kinds: Array, highs: Array, high: int) -> tuple[Array, int]:
    """Return the high part of the time at each word of EVT 2.0 or 2.1, and after the last.

    A step back by more than half the period is an overflow of the clock; a smaller one is an event
    out of order, and stays one.

    Args:
        kinds: type of each word.
        highs: the 28 bits of each word that are a time if the word is of that type.
        high: high part of the time before the words, extended by the overflows so far.
    """
    marks = np.flatnonzero(kinds == _TIME_HIGH)
    times = np.concatenate([[high], highs[marks]])
    times[1:] += high // _TIME_PERIOD * _TIME_PERIOD
    times += _TIME_PERIOD * np.cumsum(np.diff(times, prepend=high) < -(_TIME_PERIOD // 2))
    return times[np.searchsorted(marks, np.arange(kinds.size), side="right")], int(times[-1])
