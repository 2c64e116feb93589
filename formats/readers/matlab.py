"""MATLAB files: a structure with the fields x, y, p and ts, or variables of these names.

Version 5 is decoded by SciPy, which loads the chosen variable whole; version 7.3 is HDF5 and is
read in blocks. Layouts that were seen: the structure `TD` of the Event-Based Vision toolbox
(G. Orchard, github.com/gorchard/Matlab_AER_vision_functions: x and y from 1, ts in µs, p -1 or 1,
or 1 for OFF and 2 for ON), and `aedat.data.polarity` of AedatTools (x and y from 0).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol

import h5py
import numpy as np
import scipy.io

from flybench.errors import first_line
from formats.columns import Array, EventColumns, FileHeader, ParsedFile, ParsedItem, ReadOptions
from formats.errors import FormatError
from formats.readers.arrays import COLUMN_ALIASES, match_columns
from formats.readers.hdf5_links import children

_BLOCK = 1 << 17
_DEPTH_MAX = 4
"""Deepest structure within structures that is searched (assumed)."""

_PREFERRED = "TD"
_NUMBERS = "iufb"
"""Kinds of dtype that hold numbers."""


class Column(Protocol):
    """One column of a file: an array, or a data set of HDF5 that is read when it is sliced."""

    @property
    def size(self) -> int:
        """Number of values."""
        ...

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the values."""
        ...

    def __getitem__(self, rows: slice) -> Array:
        """Return values as a one-dimensional array."""
        ...


class Hdf5Column:
    """A data set of 1×n or n×1 values, as MATLAB stores vectors."""

    def __init__(self, data: Any) -> None:
        self._data = data
        self.size, self.dtype = int(data.size), data.dtype

    def __getitem__(self, rows: slice) -> Array:
        at = (0, rows) if self._data.shape[0] == 1 else (rows, 0)
        values: Array = self._data[at]
        return values


def read(path: Path, options: ReadOptions) -> ParsedFile:
    """Read the structure `TD`, or else the first that has the four columns.

    Raises:
        FormatError: there are no events, or they are damaged.
    """
    del options
    with path.open("rb") as file:
        is_hdf5 = b"MATLAB 7.3" in file.read(116)
    try:
        places = _places_in_hdf5(path) if is_hdf5 else _places_in_version_5(path)
    except FormatError:
        raise
    except MemoryError as error:
        raise FormatError(
            f"{path} does not fit into the memory of its parser. Allowed is 1 GB for a file of "
            "version 5, which is loaded whole. Save it with -v7.3, or copy it again if it is "
            "damaged."
        ) from error
    except Exception as error:  # SciPy raises almost any type on a damaged file
        why = first_line(error)
        raise FormatError(f"{path} is truncated or damaged ({why}). Copy it again.") from error
    if not places:
        raise FormatError(
            f"{path} contains no events that could be found. Allowed is a structure with the "
            "fields x, y, p and ts (or t), or variables of these names. Rename them."
        )
    ranked = sorted(places, key=lambda place: place.split(".")[-1] != _PREFERRED)
    columns = places[ranked[0]]
    _check_lengths(path, ranked[0], columns)
    first_px, off = _lowest_coordinate(columns), _off_value(columns["p"])
    facts = {"events in": ranked[0], "version": "7.3" if is_hdf5 else "5"}
    facts["coordinates"] = f"from {first_px}" + (", converted to from 0" if first_px else "")
    if off:
        facts["polarity"] = "1 is OFF, 2 is ON"
    if len(ranked) > 1:
        facts["not read"] = ", ".join(ranked[1:])
    header = FileHeader(None, facts, time_unit=None)
    return header, _items(path, columns, first_px, off)


def _items(
    path: Path, columns: Mapping[str, Column], first_px: int, off: int
) -> Iterator[ParsedItem]:
    for rows in _blocks(columns["t"]):
        try:
            t, x, y, p = (np.asarray(columns[name][rows]) for name in "txyp")
        except (OSError, RuntimeError, ValueError) as error:
            raise FormatError(
                f"{path} is damaged between events {rows.start} and {rows.stop}. Copy it again."
            ) from error
        x, y, p = (_signed(x) - first_px, _signed(y) - first_px, _signed(p) - off)
        yield EventColumns(t, x, y, p)


def _signed(values: Array) -> Array:
    """Return integers as int64, so that nothing overflows when 1 is subtracted."""
    return values.astype(np.int64) if values.dtype.kind in "iub" else values


def _blocks(column: Column) -> Iterator[slice]:
    for start in range(0, column.size, _BLOCK):
        yield slice(start, min(start + _BLOCK, column.size))


def _lowest_coordinate(columns: Mapping[str, Column]) -> int:
    """Return 0 if a coordinate is 0 anywhere in the file, else 1, as MATLAB counts [px]."""
    for name in "xy":
        column = columns[name]
        if any(column[rows].min() < 1 for rows in _blocks(column)):
            return 0
    return 1


def _off_value(column: Column) -> int:
    """Return what to subtract from polarities: 1 if they are 1 (OFF) and 2 (ON), else 0."""
    has_two = False
    for rows in _blocks(column):
        block = column[rows]
        if block.min() < 1 or block.max() > 2:
            return 0
        has_two = has_two or block.max() == 2
    return int(has_two)


def _places_in_version_5(path: Path) -> dict[str, Mapping[str, Column]]:
    """Return the columns of each structure that has all four, by its path in the file."""
    listed = scipy.io.whosmat(path)
    loose = match_columns(tuple(name for name, _, kind in listed if kind not in ("struct", "cell")))
    wanted = [name for name, _, kind in listed if kind == "struct"]
    if loose is not None:
        wanted += loose.values()
    content = scipy.io.loadmat(path, variable_names=wanted, squeeze_me=True)
    places: dict[str, Mapping[str, Column]] = {}
    _search(content, "", places)
    return places


def _search(content: Mapping[str, Any], name: str, places: dict[str, Mapping[str, Column]]) -> None:
    """Add the structures in `content`, and it itself, to `places`."""
    arrays = {key: item for key, item in content.items() if _is_vector(item)}
    names = match_columns(arrays)
    if names is not None:
        columns = {column: np.atleast_1d(arrays[key]) for column, key in names.items()}
        places[name or "variables"] = columns
    for key, item in content.items():
        is_structure = isinstance(item, np.ndarray) and item.dtype.names and item.size == 1
        if is_structure and name.count(".") < _DEPTH_MAX - 1:
            fields = {field: item[field].item() for field in item.dtype.names}
            _search(fields, f"{name}.{key}".lstrip("."), places)


def _is_vector(item: Any) -> bool:
    return isinstance(item, np.ndarray | np.generic | int | float) and (
        np.ndim(item) <= 1 and np.asarray(item).dtype.kind in _NUMBERS
    )


def _places_in_hdf5(path: Path) -> dict[str, Mapping[str, Column]]:
    file = h5py.File(path, "r")
    places: dict[str, Mapping[str, Column]] = {}

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Group) or name.startswith("#"):
            return
        vectors = {key: data for key, data in children(item) if _is_stored_vector(data)}
        names = match_columns(vectors)
        if names is not None:
            for data in vectors.values():
                _check_complete(path, data)
            columns = {column: Hdf5Column(vectors[key]) for column, key in names.items()}
            places[name.replace("/", ".") or "variables"] = columns

    visit("", file)
    file.visititems(visit)
    return places


def _is_stored_vector(item: Any) -> bool:
    return isinstance(item, h5py.Dataset) and (
        item.ndim == 2 and 1 in item.shape and item.dtype.kind in _NUMBERS
    )


def _check_complete(path: Path, data: Any) -> None:
    """Check that a data set is stored whole: HDF5 gives zeros for what is missing."""
    stored = data.id.get_storage_size()
    if data.chunks:
        rows = int(np.prod(data.chunks))
        stored = data.id.get_num_chunks() * rows * data.dtype.itemsize if stored else 0
    if stored < data.size * data.dtype.itemsize:
        raise FormatError(
            f"{path} should contain {data.size} values in {data.name} and contains fewer. It was "
            "truncated. Copy it again from where it was made."
        )


def _check_lengths(path: Path, place: str, columns: Mapping[str, Column]) -> None:
    lengths = {name: columns[name].size for name in COLUMN_ALIASES}
    if len(set(lengths.values())) > 1:
        counts = ", ".join(f"{count} {name}" for name, count in lengths.items())
        raise FormatError(
            f"{path} contains {counts} in {place}. Allowed are columns of equal length. Repair the "
            "file."
        )
