"""Text, an event a line: `t x y p` with or without a line of the sensor's size, or CSV.

Columns may be separated by blanks, tabs, commas or semicolons. A header names them; without one
they are found by what is in them: polarity holds -1, 0 and 1, time never goes back, and has
decimals or is larger than any coordinate. Times with decimals are seconds, whole ones microseconds.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from formats.columns import (
    SIDE_MAX,
    Array,
    Columns,
    Head,
    Item,
    Options,
    Reading,
    Size,
    microseconds,
)
from formats.errors import FormatError
from formats.identify import BINARY_ENDINGS
from formats.readers.arrays import columns_of

_HEAD_BYTES = 1 << 16
_BLOCK_BYTES = 1 << 22
_LINE_MAX = 4096
_BLANKS = bytes.maketrans(b",;\t\r", b"    ")
_MARK = b"\xef\xbb\xbf"
"""What some editors put before text in UTF-8."""

_COMMENTS = (b"#", b"%")
_ORDERS = (("t", "x", "y", "p"), ("x", "y", "t", "p"), ("x", "y", "p", "t"))
"""Orders of columns that are in use, the commonest first."""


@dataclass(frozen=True)
class Layout:
    """How the lines are to be read.

    Attributes:
        start: where the first event begins [bytes].
        order: name of each column, "" for one that is not read.
        size: sensor, as the line above says [px]; None: it does not.
        unit: of time.
        named: whether a header names the columns.
    """

    start: int
    order: tuple[str, ...]
    size: Size | None
    unit: str
    named: bool


def read(path: Path, options: Options) -> Reading:
    """Events of a text file.

    Raises:
        FormatError: a line is no event.
    """
    layout = _layout(path)
    if options.time_unit is not None:
        layout = replace(layout, unit=options.time_unit)
    says = {
        "columns": " ".join(name or "-" for name in layout.order)
        + (", by the header" if layout.named else ", by what is in them"),
        "time in": layout.unit.replace("u", "µ"),
    }
    return Head(layout.size, says), _items(path, layout)


def _layout(path: Path) -> Layout:
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    mark = len(_MARK) if head.startswith(_MARK) else 0
    lines = head[mark:].splitlines(keepends=True)
    if len(head) == _HEAD_BYTES:
        lines.pop()
    start, names, size, unit = mark, None, None, None
    rows: list[list[str]] = []
    for line in lines:
        words = line.translate(_BLANKS).decode("latin-1").split()
        if rows:
            rows.append(words)
            continue
        if line.startswith(_COMMENTS):
            found = _names(line.lstrip(b"#%"))
            names = found if columns_of(tuple(map(_name, found))) else names
            size = size or _size(line.lstrip(b"#%"))
        elif size is None and _size(line):
            size = _size(line)
        elif words and not _is_number(words[0]) and names is None:
            names = _names(line)
        elif words:
            rows.append(words)
            continue
        start += len(line)
    if not rows and (columns_of(tuple(map(_name, names or ()))) or (size and names is None)):
        return Layout(start, ("t", "x", "y", "p"), size, "us", names is not None)
    if not rows:
        raise _no_events(path, head)
    return _with_order(path, start, names, size, unit, rows)


def _with_order(
    path: Path,
    start: int,
    names: list[str] | None,
    size: Size | None,
    unit: str | None,
    rows: list[list[str]],
) -> Layout:
    count = len(rows[0])
    if count < 4:
        raise FormatError(
            f"{path}: the line at byte {start} has {count} columns; allowed are 4 or more: t x y p"
        )
    whole = [row for row in rows if len(row) == count and all(map(_is_number, row))]
    if not whole:
        raise FormatError(
            f"{path}: the line at byte {start} is {' '.join(rows[0])[:60]!r}, which is not all "
            "numbers; allowed are t x y p, as 0.0035 120 64 1"
        )
    if names is not None:
        plain = [_name(name) for name in names]
        found = columns_of(tuple(plain))
        if found is None or len(names) != count:
            raise FormatError(
                f"{path} has the header {' '.join(names)[:80]!r}, above {count} columns; it must "
                "name t, x, y and p; rename them, or take the header away"
            )
        back = {alias: column for column, alias in found.items()}
        order = tuple(back.get(name, "") for name in plain)
        unit = _unit(names[order.index("t")])
    else:
        order = _guess(np.array([[float(word) for word in row] for row in whole]), whole)
    if unit is None:
        unit = "s" if any(re.search(r"[.eE]", row[order.index("t")]) for row in whole) else "us"
    return Layout(start, order, size, unit, names is not None)


def _size(line: bytes) -> Size | None:
    """Width and height, where a whole line holds two whole numbers and no more."""
    words = line.translate(_BLANKS).split()
    if len(words) != 2 or not all(word.isdigit() for word in words) or not line.endswith(b"\n"):
        return None
    return int(words[0]), int(words[1])


def _no_events(path: Path, head: bytes) -> FormatError:
    if path.suffix.lower() in BINARY_ENDINGS:
        return FormatError(
            f"{path} ends in {path.suffix}, but holds no more than the beginning of a header "
            f"(bytes: {len(head)}); it is cut in its header; copy it again"
        )
    return FormatError(f"{path} holds no line of numbers; give a file with an event a line")


def _guess(values: Array, rows: list[list[str]]) -> tuple[str, ...]:
    """The columns' names by what is in them; t x y p where that is not clear."""
    columns = range(values.shape[1])
    polar = [bool(np.isin(values[:, i], (-1, 0, 1)).all()) for i in columns]
    decimal = [any(re.search(r"[.eE]", row[i]) for row in rows) for i in columns]
    timely = [
        bool((np.diff(values[:, i]) >= 0).all()) and (decimal[i] or values[-1, i] > SIDE_MAX)
        for i in columns
    ]
    more = ("",) * (values.shape[1] - 4)
    for order in _ORDERS:
        if polar[order.index("p")] and timely[order.index("t")]:
            return (*order, *more)
    last = polar[2] and not polar[3] and not decimal[0]
    return (*_ORDERS[2 if last else 0], *more)


def _items(path: Path, layout: Layout) -> Iterator[Item]:
    with path.open("rb") as file:
        file.seek(layout.start)
        at, rest = layout.start, b""
        while block := file.read(_BLOCK_BYTES):
            text = rest + block
            end = text.rfind(b"\n") + 1
            if not end and len(text) > _BLOCK_BYTES:
                raise FormatError(f"{path}: the line at byte {at} never ends; it is no event file")
            rest = text[end:]
            if end:
                yield _columns(path, text[:end], layout, at)
            at += end
        if rest.strip():
            yield _columns(path, rest, layout, at)


def _columns(path: Path, text: bytes, layout: Layout, at: int) -> Columns:
    width = len(layout.order)
    lines = text.count(b"\n") + (not text.endswith(b"\n"))
    values = _numbers(text)
    if values is None or values.size != lines * width:
        text = b"".join(line for line in text.splitlines(keepends=True) if line.strip())
        _complain(path, text, layout, at)
        values = _numbers(text)
    assert values is not None
    table = values.reshape(-1, width)
    columns = {name: table[:, i] for i, name in enumerate(layout.order) if name}
    return Columns(
        microseconds(columns["t"], layout.unit, path=path), columns["x"], columns["y"], columns["p"]
    )


def _numbers(text: bytes) -> Array | None:
    """All numbers of a text; None where something else is in it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(text.translate(_BLANKS).decode("ascii"), sep=" ")
        except (ValueError, DeprecationWarning, UnicodeDecodeError):
            return None


def _complain(path: Path, text: bytes, layout: Layout, at: int) -> None:
    """Refuse the first line that is no event."""
    for line in text.splitlines(keepends=True):
        words = line.translate(_BLANKS).decode("latin-1").split()
        if len(words) != len(layout.order) or not all(map(_is_number, words)):
            cut = "" if line.endswith(b"\n") else "the last, which may have been cut; "
            raise FormatError(
                f"{path}: the line at byte {at} is {line[:60].decode('latin-1').strip()!r}; {cut}"
                f"allowed are {len(layout.order)} numbers; repair or remove it"
            )
        at += len(line)


def _is_number(word: str) -> bool:
    return re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", word) is not None


def _names(line: bytes) -> list[str]:
    """The words of a header, which may have blanks within where commas part them."""
    words = re.split(r"[,;\t]", line.decode("utf-8", "replace"))
    return [word.strip() for word in words] if len(words) > 1 else words[0].split()


def _name(word: str) -> str:
    """A column's name without quotes and unit: `"t [us]"` and `t_us` are t."""
    return re.sub(r"(_(us|µs|ms|ns|s)|\s*[\[(].*)$", "", word.strip("\"'").lower())


def _unit(word: str) -> str | None:
    unit = re.search(r"(?:_|\[|\()(us|µs|ms|ns|s)\b", word.lower())
    return unit[1].replace("µ", "u") if unit else None
