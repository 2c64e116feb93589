"""The layout of a text file: where its events begin, its columns, and what its header states."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from formats.column_order import column_order
from formats.columns import ReadOptions, Size
from formats.errors import FormatError
from formats.identify import BINARY_ENDINGS, truncated_header
from formats.readers.arrays import match_columns

_HEAD_BYTES = 1 << 18
_BLANKS = bytes.maketrans(b",;\t\r", b"    ")
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
"""Some editors write it before text in UTF-8."""

_BOOLEANS = {"true": "1", "false": "0"}

_COMMENTS = (b"#", b"%")
_WHOLE_SECONDS_MAX = 10
"""Fewest different whole numbers that are not seconds although decimals are written (assumed)."""


@dataclass(frozen=True)
class Layout:
    """Layout of a text file.

    Attributes:
        start: position of the first event [bytes].
        order: name of each column; "-" for one that is not read.
        source: what says so.
        size: width and height of the sensor from the first line [px]; None: not stated.
        unit: unit of the timestamps that the file states; None: not stated.
        unit_source: what states it.
    """

    start: int
    order: str
    source: str
    size: Size | None
    unit: str | None = None
    unit_source: str = "from the header"


def read_layout(path: Path, options: ReadOptions) -> Layout:
    """Return the layout of a text file.

    Raises:
        FormatError: there are no events, or the order of the columns is unknown.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    start = len(_BYTE_ORDER_MARK) if head.startswith(_BYTE_ORDER_MARK) else 0
    lines = head[start:].splitlines(keepends=True)
    if len(head) == _HEAD_BYTES:
        lines.pop()
    names, size = None, None
    rows: list[list[str]] = []
    for line in lines:
        words = split_words(line)
        if rows:
            rows.append(words)
            continue
        if line.startswith(_COMMENTS):
            words = _header_words(line.lstrip(b"#%"))
            names = words if match_columns(tuple(map(_column_name, words))) else names
            size = size or _size(line.lstrip(b"#%"))
        elif size is None and _size(line):
            size = _size(line)
        elif words and not is_number(words[0]) and names is None:
            names = _header_words(line)
        elif words:
            rows.append(words)
            continue
        start += len(line)
    has_columns = match_columns(tuple(map(_column_name, names or ()))) is not None
    if not rows and (has_columns or (size and names is None)):
        return Layout(start, "txyp", "without any row", size)
    if not rows:
        raise _no_events(path, head)
    return _layout_of_rows(path, start, names, size, rows, options)


def _layout_of_rows(
    path: Path,
    start: int,
    names: list[str] | None,
    size: Size | None,
    rows: list[list[str]],
    options: ReadOptions,
) -> Layout:
    count = len(rows[0])
    if count < 4:
        raise FormatError(
            f"{path}: the line at byte {start} has {count} columns. Allowed are 4 or more: t x y "
            "p. Add the missing columns."
        )
    valid = [row for row in rows if len(row) == count and all(map(is_number, row))]
    if not valid:
        raise FormatError(
            f"{path}: the line at byte {start} is {' '.join(rows[0])[:60]!r}. Allowed are numbers "
            "t x y p, such as 0.0035 120 64 1. Repair or remove it."
        )
    if names is not None and options.columns is None:
        order, source = _order_from_header(path, names, count), "from the header"
    else:
        order, source = _order_of_rows(path, valid, options, size)
    named = names[order.index("t")] if names is not None and len(names) == count else ""
    unit, unit_source = _unit(named), "from the header"
    times = [row[order.index("t")] for row in valid]
    if unit is None and _are_whole_seconds(times, has_size=size is not None):
        unit, unit_source = "s", "because the times are written with decimals"
    return Layout(start, order, source, size, unit, unit_source)


def _order_of_rows(
    path: Path, rows: list[list[str]], options: ReadOptions, size: Size | None
) -> tuple[str, str]:
    table = np.array([[float(word) for word in row] for row in rows])
    with_decimals = [i for i in range(4) if all("." in row[i] for row in rows)]
    return column_order(
        table,
        options.columns,
        options.size or size,
        path=path,
        not_whole=with_decimals if len(with_decimals) < 3 else (),
    )


def _are_whole_seconds(words: list[str], *, has_size: bool) -> bool:
    """Return True if whole numbers are seconds because of the decimals that are written.

    They are if they are few, or if the file has a line with the size of the sensor and six decimals
    throughout, as ECD and flybench write it.
    """
    decimals = {len(word.partition(".")[2]) for word in words}
    values = {float(word) for word in words}
    return (
        0 not in decimals
        and len(decimals) == 1
        and (len(values) < _WHOLE_SECONDS_MAX or (has_size and decimals == {6}))
        and not any("e" in word.lower() for word in words)
        and all(value.is_integer() for value in values)
    )


def _order_from_header(path: Path, names: list[str], count: int) -> str:
    plain = [_column_name(name) for name in names]
    found = match_columns(tuple(plain))
    if found is None or len(names) != count:
        raise FormatError(
            f"{path} has the header {' '.join(names)[:80]!r} and {count} columns. The header must "
            "name every column, t, x, y and p among them. Rename them, or state the order with "
            "--columns, such as --columns txyp."
        )
    back = {alias: column for column, alias in found.items()}
    return "".join(back.get(name, "-") for name in plain)


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


def split_words(line: bytes) -> list[str]:
    """Return the words of a line; true and false as 1 and 0."""
    words = line.translate(_BLANKS).decode("latin-1").split()
    return [_BOOLEANS.get(word.lower(), word) for word in words]


def is_number(word: str) -> bool:
    """Return True if a word is a number."""
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
