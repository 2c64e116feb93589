"""HDF5 in the layouts of common data sets; the reader searches the file for t, x, y and p.

| data set | location and units |
| --- | --- |
| DSEC, TUM-VIE | `events/{t,x,y,p}`, µs, with `t_offset` |
| M3ED | `prophesee/left/{t,x,y,p}`, µs |
| e2vid and related | `events/{ts,xs,ys,ps}`, s, with `sensor_resolution` |
| MVSEC, v2e | `davis/left/events` or `events`, rows of four columns |
| Metavision | `CD/events`, fields x, y, p, t, µs, compressed by ECF |
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from flybench.errors import first_line
from formats.column_order import ROWS, column_order
from formats.columns import (
    Array,
    EventColumns,
    FileHeader,
    ParsedFile,
    ParsedItem,
    ReadOptions,
    Size,
)
from formats.errors import FormatError, MissingLibraryError
from formats.readers.arrays import COLUMN_ALIASES, check_no_order, match_columns
from formats.readers.hdf5_links import check_storage, children, find

_BLOCK = 1 << 17
_BLOCK_BYTES_MAX = 1 << 27
_CACHE_BYTES = 1 << 24
_OBJECTS_MAX = 10_000
"""Most objects in a file that are searched for events (assumed)."""

_ECF = 0x8ECF
_BUILT_IN = {1, 2, 3, 4, 5, 6, 32000}
"""Filters that are part of HDF5, and LZF, which is part of h5py."""


@dataclass(frozen=True)
class EventLocation:
    """Where a file stores events.

    Attributes:
        name: path of their group or data set in the file.
        columns: data set of each of t, x, y and p.
        take: function that returns the column of a given name from rows of its data set; None: the
            data set is a table whose columns have no names.
    """

    name: str
    columns: dict[str, Any]
    take: Callable[[str, Array], Array] | None


def read(path: Path, options: ReadOptions) -> ParsedFile:
    """Read the first event stream, that of a left camera if there is one.

    Raises:
        FormatError: there are no events, or they are damaged.
        MissingLibraryError: the filter that decompresses them is not installed.
    """
    _register_filters()
    try:
        file = h5py.File(path, rdcc_nbytes=_CACHE_BYTES)
        locations = _locations(file)
    except FormatError:
        raise
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise FormatError(
            f"{path} is truncated or damaged ({first_line(error)}). Copy it again from where it "
            "was made."
        ) from error
    if not locations:
        raise FormatError(
            f"{path} contains no events that could be found. Allowed are t, x, y and p (or ts, xs, "
            "ys, ps) as data sets of one group or fields of one data set, or a data set called "
            "events with 4 columns. Rename them."
        )
    chosen = next((place for place in locations if "left" in place.name), locations[0])
    _check(path, chosen)
    facts = {"events in": chosen.name}
    if len(locations) > 1:
        facts["not read"] = ", ".join(place.name for place in locations if place is not chosen)
    offset_us = _offset_us(file)
    if offset_us:
        facts["t_offset"] = f"{offset_us} µs"
    size = _size(file, chosen)
    if chosen.take is None:
        chosen, facts["columns"] = _with_order(path, chosen, options, size)
    else:
        check_no_order(path, options)
    unit, source = _unit(file, chosen)
    header = FileHeader(size, facts, time_unit=unit, unit_source=source)
    return header, _items(path, chosen)


def _with_order(
    path: Path, table: EventLocation, options: ReadOptions, size: Size | None
) -> tuple[EventLocation, str]:
    """Return a table with the function that takes its columns, and what its order is."""
    try:
        rows = table.columns["t"][:ROWS]
    except (OSError, RuntimeError, ValueError) as error:
        raise _damaged(path, table, 0, ROWS, error) from error
    if not len(rows):
        return replace(table, take=lambda _, rows: rows[:, 0]), "without any row"
    order, source = column_order(rows, options.columns, options.size or size, path=path)
    take = replace(table, take=lambda column, rows: rows[:, order.index(column)])
    return take, f"{' '.join(order)}, {source}"


def _register_filters() -> None:
    with suppress(ImportError):
        import hdf5plugin  # noqa: F401  (the import registers the filters)


def _locations(file: Any) -> list[EventLocation]:
    found: list[EventLocation] = []
    visited = 0

    def visit(name: str, item: Any) -> Any:
        nonlocal visited
        visited += 1
        location = _location(name, item)
        if location is not None:
            found.append(location)
        return True if visited > _OBJECTS_MAX else None

    root = _location("/", file)
    if root is not None:
        found.append(root)
    file.visititems(visit)
    return found


def _location(name: str, item: Any) -> EventLocation | None:
    if isinstance(item, h5py.Group):
        data_sets = {k: v for k, v in children(item) if isinstance(v, h5py.Dataset)}
        names = match_columns(tuple(data_sets))
        if names is None:
            return None
        columns = {column: data_sets[names[column]] for column in COLUMN_ALIASES}
        if any(data.ndim != 1 for data in columns.values()):
            return None
        return EventLocation(name, columns, lambda _, rows: rows)
    check_storage(item)
    one_data_set = dict.fromkeys(COLUMN_ALIASES, item)
    fields = match_columns(item.dtype.names) if item.dtype.names else None
    if fields is not None and item.ndim == 1:
        return EventLocation(name, one_data_set, lambda column, rows: rows[fields[column]])
    if name.split("/")[-1] == "events" and item.ndim == 2 and item.shape[1] == 4:
        return EventLocation(name, one_data_set, None)
    return None


def _check(path: Path, location: EventLocation) -> None:
    lengths = {name: data.shape[0] for name, data in location.columns.items()}
    if len(set(lengths.values())) > 1:
        counts = ", ".join(f"{count} {name}" for name, count in lengths.items())
        raise FormatError(
            f"{path} contains {counts} in {location.name}. Allowed are columns of equal length. "
            "Repair the file."
        )
    for name, data in location.columns.items():
        _check_filters(path, data)
        rows = data.chunks[0] if data.chunks else data.shape[0]
        missing = data.size > 0 and data.id.get_storage_size() == 0
        if data.chunks:
            missing = data.id.get_num_chunks() * rows < data.shape[0]
        if missing:
            raise FormatError(
                f"{path} should contain {data.shape[0]} events in {location.name}, but the column "
                f"{name} is incomplete. It was truncated. Copy it again from where it was made."
            )


def _check_filters(path: Path, data: Any) -> None:
    plist = data.id.get_create_plist()
    for i in range(plist.get_nfilters()):
        code = plist.get_filter(i)[0]
        if code in _BUILT_IN or h5py.h5z.filter_avail(code):
            continue
        if code == _ECF:
            raise FormatError(
                f"{path} is compressed with Prophesee's ECF filter, which is not installed. "
                "Install hdf5_ecf of Prophesee and set HDF5_PLUGIN_PATH, or use the RAW file."
            )
        raise MissingLibraryError("hdf5plugin", f"{path}, compressed with HDF5 filter {code},")


def _offset_us(file: Any) -> int:
    offset = find(file, "t_offset")
    with suppress(TypeError, ValueError):
        return int(offset[()]) if isinstance(offset, h5py.Dataset) else 0
    return 0


def _size(file: Any, location: EventLocation) -> Size | None:
    """Return the size of the sensor, if it is stored where one of the data sets has it [px]."""
    holder = find(file, location.name)
    group = holder if isinstance(holder, h5py.Group) else holder.parent
    for item in (holder, group, file):
        attributes = dict(item.attrs)
        with suppress(KeyError, TypeError, ValueError, IndexError):
            return int(attributes["width"]), int(attributes["height"])
        with suppress(KeyError, TypeError, ValueError, IndexError):
            rows, columns = (int(side) for side in attributes["sensor_resolution"][:2])
            return columns, rows
        with suppress(KeyError, TypeError, ValueError, IndexError):
            sides = _as_text(attributes["geometry"]).lower().split("x")
            return int(sides[0]), int(sides[1])
    with suppress(KeyError, TypeError, ValueError, IndexError):
        width, height = (int(side) for side in find(group, "calib/resolution")[:2])
        return width, height
    return None


def _as_text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def _items(path: Path, location: EventLocation) -> Iterator[ParsedItem]:
    take = location.take
    assert take is not None
    data_sets = location.columns.values()
    count = location.columns["t"].shape[0]
    rows = max(_BLOCK, *(data.chunks[0] if data.chunks else 0 for data in data_sets))
    widest = max(
        data.dtype.itemsize * int(np.prod(data.shape[1:], dtype=np.int64)) for data in data_sets
    )
    rows = max(min(rows, _BLOCK_BYTES_MAX // widest), 1)
    for start in range(0, count, rows):
        blocks: dict[int, Array] = {}
        columns = {}
        for name, data in location.columns.items():
            try:
                if id(data) not in blocks:
                    blocks[id(data)] = data[start : start + rows]
            except (OSError, RuntimeError, ValueError) as error:
                end = min(start + rows, count)
                raise _damaged(path, location, start, end, error) from error
            columns[name] = take(name, blocks[id(data)])
        yield EventColumns(columns["t"], columns["x"], columns["y"], columns["p"])


def _damaged(
    path: Path, location: EventLocation, start: int, end: int, error: Exception
) -> FormatError:
    return FormatError(
        f"{path} is damaged in {location.name} between events {start} and {end} "
        f"({first_line(error)}). Copy it again."
    )


def _unit(file: Any, location: EventLocation) -> tuple[str | None, str]:
    """Return the unit of the timestamps that the file states, and what states it."""
    attributes = location.columns["t"].attrs
    unit = _as_text(attributes.get("unit", attributes.get("units", ""))).replace("µ", "u")
    if unit in ("s", "ms", "us", "ns"):
        return unit, "from the attribute of the times"
    if isinstance(file.get("ms_to_idx"), h5py.Dataset):
        return "us", "as DSEC defines"
    if location.name == "CD/events":
        return "us", "as Metavision defines"
    return None, ""
