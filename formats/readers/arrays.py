"""NumPy files: a structured array, or one array a column; read in blocks, never whole."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from formats.columns import Array, Columns, Head, Item, Options, Reading, Size, microseconds
from formats.errors import FormatError

NAMES = {
    "t": ("t", "ts", "time", "times", "timestamp", "timestamps", "t_us", "time_us"),
    "x": ("x", "xs", "x_pos"),
    "y": ("y", "ys", "y_pos"),
    "p": ("p", "ps", "pol", "polarity", "polarities", "on"),
}
"""What the columns are called, ours first."""

_BLOCK = 1 << 17
_SIZE_NAMES = ("width", "height")


class ArrayStream:
    """An array in a `.npy` stream, read a block of rows at a time."""

    def __init__(self, file: BinaryIO, path: Path, stored: int) -> None:
        """Read the header.

        Args:
            file: at its beginning.
            path: the file, for messages.
            stored: bytes in the stream.

        Raises:
            FormatError: it promises more than there is, or Python objects.
        """
        version = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0
        if version >= (2, 0):
            read = np.lib.format.read_array_header_2_0
        self.shape, fortran, self.dtype = read(file)
        if self.dtype.hasobject or (fortran and len(self.shape) > 1):
            raise FormatError(
                f"{path} holds Python objects or columns in Fortran's order; save it again as "
                "plain arrays, row by row"
            )
        self.row_bytes = self.dtype.itemsize * int(np.prod(self.shape[1:], dtype=np.int64))
        promised = self.row_bytes * (self.shape[0] if self.shape else 1)
        if promised > stored or any(side < 0 for side in self.shape):
            raise FormatError(
                f"{path} promises {promised} bytes of events and holds {stored}; it was cut; copy "
                "it again from where it was made"
            )
        self._file = file
        self._path = path
        self._left = self.shape[0] if self.shape else 1

    def block(self) -> Array:
        """The next rows, of which there are 0 at the end."""
        rows = min(_BLOCK, self._left)
        self._left -= rows
        data = self._file.read(rows * self.row_bytes)
        if len(data) < rows * self.row_bytes:
            raise FormatError(f"{self._path} ends within its events; copy it again")
        return np.frombuffer(data, self.dtype).reshape(rows, *self.shape[1:])


def columns_of(names: Mapping[str, Any] | tuple[str, ...]) -> dict[str, str] | None:
    """Which of the names is t, x, y and p; None where one of them is missing."""
    lower = {name.lower(): name for name in names}
    found = {}
    for column, aliases in NAMES.items():
        alias = next((alias for alias in aliases if alias in lower), None)
        if alias is None:
            return None
        found[column] = lower[alias]
    return found


def read_npy(path: Path, options: Options) -> Reading:
    """A structured array of events, or one of four columns t x y p."""
    file = path.open("rb")
    stream = ArrayStream(file, path, path.stat().st_size)
    return Head(None, _shown(stream)), _from_one(path, stream, options)


def read_npz(path: Path, options: Options) -> Reading:
    """An archive of columns t, x, y, p, or of one structured array; `width` and `height` if so."""
    archive = zipfile.ZipFile(path)
    members = {i.filename.removesuffix(".npy"): i for i in archive.infolist()}
    size = _size_in(archive, members, path)
    wanted = columns_of(members)
    if wanted is not None:
        says = {"arrays": " ".join(wanted.values())}
        return Head(size, says), _from_columns(path, archive, members, wanted, options)
    for info in members.values():
        stream = ArrayStream(_member(archive, info), path, info.file_size)
        if stream.dtype.names and columns_of(stream.dtype.names) is not None:
            return Head(size, {"array": info.filename} | _shown(stream)), _from_one(
                path, stream, options
            )
    raise FormatError(
        f"{path} holds the arrays {', '.join(members) or 'none'}; allowed are t, x, y and p, or "
        "one structured array with these fields; save it so"
    )


def _shown(stream: ArrayStream) -> dict[str, str]:
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
        ArrayStream(_member(archive, members[n]), path, members[n].file_size) for n in _SIZE_NAMES
    ]
    width, height = (int(stream.block().ravel()[0]) for stream in streams)
    return width, height


def _from_one(path: Path, stream: ArrayStream, options: Options) -> Iterator[Item]:
    names = columns_of(stream.dtype.names) if stream.dtype.names else None
    plain = stream.dtype.names is None and len(stream.shape) == 2 and stream.shape[1] == 4
    if names is None and not plain:
        raise FormatError(
            f"{path} holds an array of {stream.shape} {stream.dtype}; allowed is a structured "
            "array with the fields t, x, y and p, or columns t x y p, 4 a row; save it so"
        )
    while (block := stream.block()).shape[0]:
        if names is not None:
            columns = {column: block[name] for column, name in names.items()}
        else:
            columns = dict(zip("txyp", block.T, strict=True))
        t = microseconds(columns["t"], options.time_unit, path=path)
        yield Columns(t, columns["x"], columns["y"], columns["p"])


def _from_columns(
    path: Path,
    archive: zipfile.ZipFile,
    members: Mapping[str, zipfile.ZipInfo],
    wanted: Mapping[str, str],
    options: Options,
) -> Iterator[Item]:
    with ExitStack() as stack:
        streams = {}
        for column, name in wanted.items():
            file = stack.enter_context(archive.open(members[name]))
            streams[column] = ArrayStream(file, path, members[name].file_size)  # type: ignore[arg-type]
        shapes = {stream.shape for stream in streams.values()}
        if len(shapes) > 1 or len(streams["t"].shape) != 1:
            raise FormatError(
                f"{path} holds columns of the shapes {sorted(shapes)}; allowed is one, of one "
                "dimension; save it again"
            )
        while (t := streams["t"].block()).size:
            x, y, p = (streams[name].block() for name in "xyp")
            yield Columns(microseconds(t, options.time_unit, path=path), x, y, p)
