"""Text and CSV files with one event per line.

A line with the width and height of the sensor may come first. Columns are separated by blanks,
tabs, commas or semicolons. A header may name them. Without a header `formats.column_order` finds
them by their values.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from formats.columns import Array, EventColumns, FileHeader, ParsedFile, ParsedItem, ReadOptions
from formats.errors import FormatError
from formats.readers.text_layout import Layout, is_number, read_layout, split_words

_BLOCK_BYTES = 1 << 22
_IN_WORD = bytes(letter > 32 and letter not in b",;" for letter in range(256))
"""1 for each character of a number, 0 for each that separates numbers."""
_BLANKS = bytes.maketrans(b",;\t\r", b"    ")
_LINE_FEED = ord("\n")
_BOOLEANS = re.compile(rb"\b(?:(true)|false)\b", re.IGNORECASE)


def read(path: Path, options: ReadOptions) -> ParsedFile:
    """Read events from a text file.

    Raises:
        FormatError: a line is not an event.
    """
    layout = read_layout(path, options)
    facts = {"columns": f"{' '.join(layout.order)}, {layout.source}"}
    header = FileHeader(layout.size, facts, time_unit=layout.unit, unit_source=layout.unit_source)
    return header, _items(path, layout)


def _items(path: Path, layout: Layout) -> Iterator[ParsedItem]:
    with path.open("rb") as file:
        file.seek(layout.start)
        at, rest = layout.start, b""
        while block := file.read(_BLOCK_BYTES):
            text = rest + block
            end = text.rfind(b"\n") + 1
            if not end and len(text) > _BLOCK_BYTES:
                raise FormatError(
                    f"{path}: the line at byte {at} does not end. Give a file with one event a "
                    "line."
                )
            rest = text[end:]
            if end:
                yield from _columns(path, text[:end], layout, at)
            at += end
        if rest.strip():
            yield from _columns(path, rest, layout, at)


def _columns(path: Path, text: bytes, layout: Layout, at: int) -> Iterator[EventColumns]:
    """Yield the events in a text; before an error, those before the wrong line.

    Args:
        path: path of the file, for messages.
        text: lines of the file.
        layout: layout of the file.
        at: position of the text in the file [bytes].
    """
    error: FormatError | None = None
    lines = text.count(b"\n") + (not text.endswith(b"\n"))
    values, columns = _numbers(text), len(layout.order)
    is_even = _has_even_lines(text, lines, columns)
    if values is None or values.size != lines * columns or not is_even:
        text, error = _valid_lines(path, text, layout, at)
        values = _numbers(text)
    assert values is not None
    table = values.reshape(-1, columns)
    if len(table):
        t, x, y, p = (table[:, layout.order.index(name)] for name in "txyp")
        yield EventColumns(t, x, y, p)
    if error is not None:
        raise error


def _has_even_lines(text: bytes, lines: int, columns: int) -> bool:
    """Return True if each of the lines has this number of words."""
    in_word = np.frombuffer(b"\0" + text.translate(_IN_WORD), np.bool_)
    words = np.flatnonzero(in_word[1:] > in_word[:-1])
    if words.size != lines * columns:
        return False
    rows = words.reshape(lines, columns)
    ends = np.flatnonzero(np.frombuffer(text, np.uint8) == _LINE_FEED)
    starts_later = rows[1:, 0] > ends[: lines - 1]
    ends_earlier = rows[: ends.size, -1] < ends
    return bool(starts_later.all() and ends_earlier.all())


def _numbers(text: bytes) -> Array | None:
    """Return all numbers in a text, true and false as 1 and 0; None if there is anything else."""
    if any(letter in text for letter in (b"t", b"T", b"f", b"F")):
        text = _BOOLEANS.sub(lambda found: b"1" if found[1] else b"0", text)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(text.translate(_BLANKS).decode("ascii"), sep=" ")
        except (ValueError, DeprecationWarning, UnicodeDecodeError):
            return None


def _valid_lines(
    path: Path, text: bytes, layout: Layout, at: int
) -> tuple[bytes, FormatError | None]:
    """Return the lines before the first that is not an event, without empty ones, and its error."""
    valid: list[bytes] = []
    for line in text.splitlines(keepends=True):
        words = split_words(line)
        if words and (len(words) != len(layout.order) or not all(map(is_number, words))):
            last = "" if line.endswith(b"\n") else " It is the last and may be truncated."
            return b"".join(valid), FormatError(
                f"{path}: the line at byte {at} is {line[:60].decode('latin-1').strip()!r}.{last} "
                f"Allowed are {len(layout.order)} numbers. Repair or remove it."
            )
        if words:
            valid.append(line)
        at += len(line)
    return b"".join(valid), None
