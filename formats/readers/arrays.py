"""NumPy files: a structured array, or one array per column; read in blocks of rows."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from formats.columns import (
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
    """Read a structured array of events, or an array with the four columns t, x, y, p."""
    file = path.open("rb")
    stream = NpyStream(file, path, path.stat().st_size)
    return FileHeader(None, _array_facts(stream)), _from_one(path, stream, options)


def read_npz(path: Path, options: ReadOptions) -> ParsedFile:
    """Read an archive of arrays t, x, y and p, or of one structured array.

    Arrays `width` and `height`, if present, are the size of the sensor.
    """
    archive = zipfile.ZipFile(path)
    members = {i.filename.removesuffix(".npy"): i for i in archive.infolist()}
    _check_not_other_zip(path, archive)
    size = _size_in(archive, members, path)
    wanted = match_columns(members)
    if wanted is not None:
        facts = {"arrays": " ".join(wanted.values())}
        return FileHeader(size, facts), _from_columns(path, archive, members, wanted, options)
    for info in members.values():
        stream = NpyStream(_member(archive, info), path, info.file_size)
        if stream.dtype.names and match_columns(stream.dtype.names) is not None:
            facts = {"array": info.filename} | _array_facts(stream)
            return FileHeader(size, facts), _from_one(path, stream, options)
    raise FormatError(
        f"{path} contains the arrays {', '.join(members) or 'none'}. Allowed are arrays t, x, y "
        "and p, or one structured array with these fields. Save it in one of these forms."
    )


def _check_not_other_zip(path: Path, archive: zipfile.ZipFile) -> None:
    """Refuse a zip archive of other files than arrays, such as one of the text of a data set."""
    names = [name for name in archive.namelist() if not name.endswith("/")]
    if names and not any(name.endswith(".npy") for name in names):
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        raise FormatError(
            f"{path} is a zip archive of {names[0]}{more}. Allowed is an archive of NumPy arrays. "
            "Unpack it first, and give the file of events in it."
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


def _from_one(path: Path, stream: NpyStream, options: ReadOptions) -> Iterator[ParsedItem]:
    names = match_columns(stream.dtype.names) if stream.dtype.names else None
    plain = stream.dtype.names is None and len(stream.shape) == 2 and stream.shape[1] == 4
    if names is None and not plain:
        raise FormatError(
            f"{path} contains an array of shape {stream.shape} and dtype {stream.dtype}. Allowed "
            "is a structured array with the fields t, x, y and p, or 4 columns t, x, y, p. Save it "
            "in one of these forms."
        )
    while (block := stream.block()).shape[0]:
        if names is not None:
            columns = {column: block[name] for column, name in names.items()}
        else:
            columns = dict(zip("txyp", block.T, strict=True))
        t = to_microseconds(columns["t"], options.time_unit, path=path)
        yield EventColumns(t, columns["x"], columns["y"], columns["p"])


def _from_columns(
    path: Path,
    archive: zipfile.ZipFile,
    members: Mapping[str, zipfile.ZipInfo],
    wanted: Mapping[str, str],
    options: ReadOptions,
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
            x, y, p = (streams[name].block() for name in "xyp")
            yield EventColumns(to_microseconds(t, options.time_unit, path=path), x, y, p)
