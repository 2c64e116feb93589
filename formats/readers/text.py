"""Text and CSV files with one event per line.

A line with the width and height of the sensor may come first. Columns are separated by blanks,
tabs, commas or semicolons. A header may name them. Without a header the reader recognises them by
their values: polarity is -1, 0 or 1; time never decreases, and has decimals or exceeds every
possible coordinate. Times with decimals are in seconds, integers in microseconds.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from formats.columns import (
    MAX_SIDE_PX,
    Array,
    EventColumns,
    FileHeader,
    ParsedFile,
    ParsedItem,
    ReadOptions,
    Size,
    to_microseconds,
)
from formats.errors import FormatError
from formats.identify import BINARY_ENDINGS, truncated_header
from formats.readers.arrays import match_columns

_HEAD_BYTES = 1 << 16
_BLOCK_BYTES = 1 << 22
_LINE_MAX = 4096
_BLANKS = bytes.maketrans(b",;\t\r", b"    ")
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
"""Some editors write it before text in UTF-8."""

_COMMENTS = (b"#", b"%")
_ORDERS = (("t", "x", "y", "p"), ("x", "y", "t", "p"), ("x", "y", "p", "t"))
"""Orders of columns that are in use, the most common first."""


@dataclass(frozen=True)
class Layout:
    """Layout of a text file.

    Attributes:
        start: position of the first event [bytes].
        order: name of each column; "" for one that is not read.
        size: width and height of the sensor from the first line [px]; None: not stated.
        unit: unit of the timestamps, one of `UNITS_US`.
        named: True if a header names the columns.
    """

    start: int
    order: tuple[str, ...]
    size: Size | None
    unit: str
    named: bool


def read(path: Path, options: ReadOptions) -> ParsedFile:
    """Read events from a text file.

    Raises:
        FormatError: a line is not an event.
    """
    layout = _layout(path)
    if options.time_unit is not None:
        layout = replace(layout, unit=options.time_unit)
    facts = {
        "columns": " ".join(name or "-" for name in layout.order)
        + (", from the header" if layout.named else ", from their values"),
        "time unit": layout.unit.replace("u", "µ"),
    }
    return FileHeader(layout.size, facts), _items(path, layout)


def _layout(path: Path) -> Layout:
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    start = len(_BYTE_ORDER_MARK) if head.startswith(_BYTE_ORDER_MARK) else 0
    lines = head[start:].splitlines(keepends=True)
    if len(head) == _HEAD_BYTES:
        lines.pop()
    names, size = None, None
    rows: list[list[str]] = []
    for line in lines:
        words = line.translate(_BLANKS).decode("latin-1").split()
        if rows:
            rows.append(words)
            continue
        if line.startswith(_COMMENTS):
            words = _header_words(line.lstrip(b"#%"))
            names = words if match_columns(tuple(map(_column_name, words))) else names
            size = size or _size(line.lstrip(b"#%"))
        elif size is None and _size(line):
            size = _size(line)
        elif words and not _is_number(words[0]) and names is None:
            names = _header_words(line)
        elif words:
            rows.append(words)
            continue
        start += len(line)
    has_columns = match_columns(tuple(map(_column_name, names or ()))) is not None
    if not rows and (has_columns or (size and names is None)):
        return Layout(start, ("t", "x", "y", "p"), size, "us", names is not None)
    if not rows:
        raise _no_events(path, head)
    return _layout_of_rows(path, start, names, size, rows)


def _layout_of_rows(
    path: Path, start: int, names: list[str] | None, size: Size | None, rows: list[list[str]]
) -> Layout:
    count = len(rows[0])
    if count < 4:
        raise FormatError(
            f"{path}: the line at byte {start} has {count} columns. Allowed are 4 or more: t x y "
            "p. Add the missing columns."
        )
    valid = [row for row in rows if len(row) == count and all(map(_is_number, row))]
    if not valid:
        raise FormatError(
            f"{path}: the line at byte {start} is {' '.join(rows[0])[:60]!r}. Allowed are numbers "
            "t x y p, such as 0.0035 120 64 1. Repair or remove it."
        )
    unit = None
    if names is not None:
        order = _order_from_header(path, names, count)
        unit = _unit(names[order.index("t")])
    else:
        order = _guess(np.array([[float(word) for word in row] for row in valid]), valid)
    if unit is None:
        unit = "s" if any(re.search(r"[.eE]", row[order.index("t")]) for row in valid) else "us"
    return Layout(start, order, size, unit, names is not None)


def _order_from_header(path: Path, names: list[str], count: int) -> tuple[str, ...]:
    plain = [_column_name(name) for name in names]
    found = match_columns(tuple(plain))
    if found is None or len(names) != count:
        raise FormatError(
            f"{path} has the header {' '.join(names)[:80]!r} and {count} columns. The header must "
            "name every column, t, x, y and p among them. Rename them or remove the header."
        )
    back = {alias: column for column, alias in found.items()}
    return tuple(back.get(name, "") for name in plain)


def _size(line: bytes) -> Size | None:
    """Return width and height if the line consists of exactly two whole numbers."""
    words = line.translate(_BLANKS).split()
    if len(words) != 2 or not all(word.isdigit() for word in words) or not line.endswith(b"\n"):
        return None
    return int(words[0]), int(words[1])


def _no_events(path: Path, head: bytes) -> FormatError:
    if path.suffix.lower() in BINARY_ENDINGS:
        return truncated_header(path, head)
    return FormatError(
        f"{path} has no line of numbers. Allowed is one event per line. Give such a file."
    )


def _guess(values: Array, rows: list[list[str]]) -> tuple[str, ...]:
    """Return the names of columns from their values; t x y p if that is ambiguous."""
    columns = range(values.shape[1])
    may_be_p = [bool(np.isin(values[:, i], (-1, 0, 1)).all()) for i in columns]
    decimal = [any(re.search(r"[.eE]", row[i]) for row in rows) for i in columns]
    may_be_t = [
        bool((np.diff(values[:, i]) >= 0).all()) and (decimal[i] or values[-1, i] > MAX_SIDE_PX)
        for i in columns
    ]
    more = ("",) * (values.shape[1] - 4)
    for order in _ORDERS:
        if may_be_p[order.index("p")] and may_be_t[order.index("t")]:
            return (*order, *more)
    time_last = may_be_p[2] and not may_be_p[3] and not decimal[0]
    return (*_ORDERS[2 if time_last else 0], *more)


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
                yield _columns(path, text[:end], layout, at)
            at += end
        if rest.strip():
            yield _columns(path, rest, layout, at)


def _columns(path: Path, text: bytes, layout: Layout, at: int) -> EventColumns:
    width = len(layout.order)
    lines = text.count(b"\n") + (not text.endswith(b"\n"))
    values = _numbers(text)
    if values is None or values.size != lines * width:
        text = b"".join(line for line in text.splitlines(keepends=True) if line.strip())
        _check_lines(path, text, layout, at)
        values = _numbers(text)
    assert values is not None
    table = values.reshape(-1, width)
    columns = {name: table[:, i] for i, name in enumerate(layout.order) if name}
    return EventColumns(
        to_microseconds(columns["t"], layout.unit, path=path),
        columns["x"],
        columns["y"],
        columns["p"],
    )


def _numbers(text: bytes) -> Array | None:
    """Return all numbers in a text; None if it contains anything else."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(text.translate(_BLANKS).decode("ascii"), sep=" ")
        except (ValueError, DeprecationWarning, UnicodeDecodeError):
            return None


def _check_lines(path: Path, text: bytes, layout: Layout, at: int) -> None:
    """Check that every line is an event; `at` is the position of the text [bytes]."""
    for line in text.splitlines(keepends=True):
        words = line.translate(_BLANKS).decode("latin-1").split()
        if len(words) != len(layout.order) or not all(map(_is_number, words)):
            last = "" if line.endswith(b"\n") else " It is the last and may be truncated."
            raise FormatError(
                f"{path}: the line at byte {at} is {line[:60].decode('latin-1').strip()!r}.{last} "
                f"Allowed are {len(layout.order)} numbers. Repair or remove it."
            )
        at += len(line)


def _is_number(word: str) -> bool:
    return re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", word) is not None


def _header_words(line: bytes) -> list[str]:
    """Split a header into column names; they may contain blanks if commas separate them."""
    words = re.split(r"[,;\t]", line.decode("utf-8", "replace"))
    return [word.strip() for word in words] if len(words) > 1 else words[0].split()


def _column_name(word: str) -> str:
    """Return a column name without quotes and unit: `"t [us]"` and `t_us` give t."""
    return re.sub(r"(_(us|µs|ms|ns|s)|\s*[\[(].*)$", "", word.strip("\"'").lower())


def _unit(word: str) -> str | None:
    unit = re.search(r"(?:_|\[|\()(us|µs|ms|ns|s)\b", word.lower())
    return unit[1].replace("µ", "u") if unit else None
