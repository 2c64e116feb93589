"""NumPy files: a structured array, a table, or one array per column; read in blocks of rows."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from formats.column_order import column_order
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

COLUMN_ALIASES = {
    "t": ("t", "ts", "time", "times", "timestamp", "timestamps", "t_us", "time_us"),
    "x": ("x", "xs", "x_pos"),
    "y": ("y", "ys", "y_pos"),
    "p": ("p", "ps", "pol", "polarity", "polarities", "on"),
}
"""Accepted names of each column; the first is the one that flybench writes."""

_BLOCK = 1 << 17
_SIZE_NAMES = ("width", "height")


class NpyStream:
    """An array in `.npy` format that is read one block of rows at a time."""

    def __init__(self, file: BinaryIO, path: Path, stored: int) -> None:
        """Read the header.

        Args:
            file: stream at the beginning of the array.
            path: path of the file, for error messages.
            stored: length of the stream [bytes].

        Raises:
            FormatError: the array contains Python objects or is longer than the stream.
        """
        version = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0
        if version >= (2, 0):
            read = np.lib.format.read_array_header_2_0
        self.shape, fortran, self.dtype = read(file)
        if self.dtype.hasobject or (fortran and len(self.shape) > 1):
            raise FormatError(
                f"{path} contains Python objects, or an array in Fortran order. Allowed are arrays "
                "of numbers in C order. Save it again with numpy.ascontiguousarray."
            )
        self.row_bytes = self.dtype.itemsize * int(np.prod(self.shape[1:], dtype=np.int64))
        needed = self.row_bytes * (self.shape[0] if self.shape else 1)
        if needed > stored or any(side < 0 for side in self.shape):
            raise FormatError(
                f"{path} should contain {needed} bytes of events and contains {stored}. It was "
                "truncated. Copy it again from where it was made."
            )
        self._file = file
        self._path = path
        self._left = self.shape[0] if self.shape else 1

    def block(self) -> Array:
        """Return the next rows; 0 rows at the end."""
        rows = min(_BLOCK, self._left)
        self._left -= rows
        data = self._file.read(rows * self.row_bytes)
        if len(data) < rows * self.row_bytes:
            raise FormatError(f"{self._path} ends within its events. Copy it again.")
        return np.frombuffer(data, self.dtype).reshape(rows, *self.shape[1:])


def match_columns(names: Mapping[str, Any] | tuple[str, ...]) -> dict[str, str] | None:
    """Return the name of each of the columns t, x, y and p; None if one of them is missing."""
    lower = {name.lower(): name for name in names}
    found = {}
    for column, aliases in COLUMN_ALIASES.items():
        alias = next((alias for alias in aliases if alias in lower), None)
        if alias is None:
            return None
        found[column] = lower[alias]
    return found


def read_npy(path: Path, options: ReadOptions) -> ParsedFile:
    """Read a structured array of events, or an array with four columns."""
    file = path.open("rb")
    stream = NpyStream(file, path, path.stat().st_size)
    return _from_one(path, stream, None, _array_facts(stream), options)


def read_npz(path: Path, options: ReadOptions) -> ParsedFile:
    """Read an archive of arrays t, x, y and p, or of one array as in a `.npy` file.

    Arrays `width` and `height`, if present, are the size of the sensor.
    """
    archive = zipfile.ZipFile(path)
    members = {i.filename.removesuffix(".npy"): i for i in archive.infolist()}
    size = _size_in(archive, members, path)
    wanted = match_columns(members)
    if wanted is not None:
        facts = {"arrays": " ".join(wanted.values())}
        header = FileHeader(size, facts, time_unit=None)
        check_no_order(path, options)
        return header, _from_columns(path, archive, members, wanted)
    for info in members.values():
        stream = NpyStream(_member(archive, info), path, info.file_size)
        if _is_table(stream) or match_columns(stream.dtype.names or ()) is not None:
            facts = {"array": info.filename} | _array_facts(stream)
            return _from_one(path, stream, size, facts, options)
    raise FormatError(
        f"{path} contains the arrays {', '.join(members) or 'none'}. Allowed are arrays t, x, y "
        "and p, one structured array with these fields, or one array with four columns. Save it in "
        "one of these forms."
    )


def check_no_order(path: Path, options: ReadOptions) -> None:
    """Check that the user states no order of columns for a file that names its columns.

    Raises:
        FormatError: the user does.
    """
    if options.columns is not None:
        raise FormatError(
            f"--columns is {options.columns}, but {path} names its columns. Allowed is --columns "
            "for columns without names. Leave --columns out."
        )


def _array_facts(stream: NpyStream) -> dict[str, str]:
    names = stream.dtype.names
    return {"fields": " ".join(names) if names else f"{stream.shape} of {stream.dtype}"}


def _member(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Any:
    return archive.open(info)


def _size_in(
    archive: zipfile.ZipFile, members: Mapping[str, zipfile.ZipInfo], path: Path
) -> Size | None:
    if any(name not in members for name in _SIZE_NAMES):
        return None
    streams = [
        NpyStream(_member(archive, members[n]), path, members[n].file_size) for n in _SIZE_NAMES
    ]
    width, height = (int(stream.block().ravel()[0]) for stream in streams)
    return width, height


def _is_table(stream: NpyStream) -> bool:
    is_number = stream.dtype.kind in "iuf"
    return is_number and len(stream.shape) == 2 and stream.shape[1] == 4


def _from_one(
    path: Path, stream: NpyStream, size: Size | None, facts: dict[str, str], options: ReadOptions
) -> ParsedFile:
    names = match_columns(stream.dtype.names or ())
    if names is not None:
        check_no_order(path, options)
        columns = _named_columns(stream, names)
        return FileHeader(size, facts, time_unit=None), columns
    if not _is_table(stream):
        raise FormatError(
            f"{path} contains an array of shape {stream.shape} and dtype {stream.dtype}. Allowed "
            "is a structured array with the fields t, x, y and p, or an array with four columns. "
            "Save it in one of these forms. For pictures, use flybench emulate."
        )
    first = stream.block()
    order = "txyp"
    if len(first):
        order, source = column_order(first, options.columns, options.size or size, path=path)
        facts = facts | {"columns": f"{' '.join(order)}, {source}"}
    header = FileHeader(size, facts, time_unit=None)
    return header, _table_columns(chain([first], _blocks(stream)), order)


def _blocks(stream: NpyStream) -> Iterator[Array]:
    while len(block := stream.block()):
        yield block


def _named_columns(stream: NpyStream, names: Mapping[str, str]) -> Iterator[ParsedItem]:
    for block in _blocks(stream):
        yield EventColumns(*(block[names[column]] for column in "txyp"))


def _table_columns(blocks: Iterable[Array], order: str) -> Iterator[ParsedItem]:
    for block in blocks:
        yield EventColumns(*(block[:, order.index(column)] for column in "txyp"))


def _from_columns(
    path: Path,
    archive: zipfile.ZipFile,
    members: Mapping[str, zipfile.ZipInfo],
    wanted: Mapping[str, str],
) -> Iterator[ParsedItem]:
    with ExitStack() as stack:
        streams = {}
        for column, name in wanted.items():
            file = stack.enter_context(archive.open(members[name]))
            streams[column] = NpyStream(file, path, members[name].file_size)  # type: ignore[arg-type]
        shapes = {stream.shape for stream in streams.values()}
        if len(shapes) > 1 or len(streams["t"].shape) != 1:
            raise FormatError(
                f"{path} contains columns of the shapes {sorted(shapes)}. Allowed are "
                "one-dimensional arrays of equal length. Save it again."
            )
        while (t := streams["t"].block()).size:
            yield EventColumns(t, *(streams[name].block() for name in "xyp"))
