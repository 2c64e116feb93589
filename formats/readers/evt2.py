"""Prophesee RAW, EVT 2.0: 32-bit words, each with one event or the high part of the time.

flybench has its own decoder because faery 0.7.1 takes every step back of the time for an overflow,
which puts all events after a late one 2^34 µs (5 hours) into the future.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from formats.columns import EventColumns, ParsedFile, ParsedItem, ReadOptions
from formats.readers.evt21 import high_times
from formats.readers.prophesee import check_version, file_header, read_words, shown_facts

_OFF, _ON = 0, 1


def read(path: Path, options: ReadOptions) -> ParsedFile:
    """Read contrast events; triggers are skipped.

    Raises:
        FormatError: the header states another format.
    """
    del options
    facts, start = check_version(path, "evt2")
    return file_header(facts, shown_facts(facts)), _items(path, start)


def _items(path: Path, start: int) -> Iterator[ParsedItem]:
    high = 0
    for words in read_words(path, start, np.dtype("<u4")):
        fields = words.astype(np.int64)
        kinds = fields >> 28
        now, high = high_times(kinds, fields & 0xFFF_FFFF, high)
        chosen = (kinds == _OFF) | (kinds == _ON)
        event = fields[chosen]
        t = (now[chosen] << 6) | ((event >> 22) & 0x3F)
        yield EventColumns(t, (event >> 11) & 0x7FF, event & 0x7FF, kinds[chosen] == _ON)
