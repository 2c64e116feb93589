"""HDF5 in the layouts of the common data sets: wherever t, x, y and p are found.

| layout | where |
| --- | --- |
| DSEC, TUM-VIE | `events/{t,x,y,p}`, µs, with `t_offset` |
| M3ED | `prophesee/left/{t,x,y,p}`, µs |
| e2vid and its kin | `events/{ts,xs,ys,ps}`, s, with `sensor_resolution` |
| MVSEC | `davis/left/events`, rows of x, y, t [s], p = ±1 |
| Metavision | `CD/events`, fields x, y, p, t, µs, compressed by ECF |
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from formats.columns import Array, Columns, Head, Item, Options, Reading, Size, microseconds
from formats.errors import FormatError, MissingLibraryError
from formats.readers.arrays import NAMES, columns_of

_BLOCK = 1 << 17
_BLOCK_BYTES_MAX = 1 << 27
_CACHE_BYTES = 1 << 24
_OBJECTS_MAX = 10_000
"""Objects that are looked at in search of events (assumed)."""

_ECF = 0x8ECF
_BUILT_IN = {1, 2, 3, 4, 5, 6, 32000}
"""Filters of HDF5 itself, and LZF, which h5py brings."""


@dataclass(frozen=True)
class Stream:
    """Events somewhere in a file.

    Attributes:
        name: path of their group or data set.
        columns: data set of each of t, x, y and p.
        take: from a data set's rows to the column of that name.
    """

    name: str
    columns: dict[str, Any]
    take: Callable[[str, Array], Array]


def read(path: Path, options: Options) -> Reading:
    """The first stream of events, of a left camera if there is one.

    Raises:
        FormatError: there are no events, or they are damaged.
        MissingLibraryError: they are compressed by what is not installed.
    """
    _register_filters()
    try:
        file = h5py.File(path, rdcc_nbytes=_CACHE_BYTES)
        streams = _streams(file)
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise FormatError(
            f"{path} is cut or damaged ({_first_line(error)}); copy it again from where it was made"
        ) from error
    if not streams:
        raise FormatError(
            f"{path} holds no events that could be found; looked for are t, x, y and p (or ts, xs, "
            "ys, ps) in one group, fields of one data set, or rows of 4 called events; rename them"
        )
    stream = next((s for s in streams if "left" in s.name), streams[0])
    _check(path, stream)
    says = {"events in": stream.name}
    if len(streams) > 1:
        says["also there"] = ", ".join(s.name for s in streams if s is not stream)
    offset_us = _offset_us(file)
    if offset_us:
        says["t_offset"] = f"{offset_us} µs"
    return Head(_size(file, stream), says), _items(path, stream, options)


def _register_filters() -> None:
    with suppress(ImportError):
        import hdf5plugin  # noqa: F401  (it registers them)


def _streams(file: Any) -> list[Stream]:
    found: list[Stream] = []
    seen = 0

    def visit(name: str, thing: Any) -> Any:
        nonlocal seen
        seen += 1
        stream = _stream(name, thing)
        if stream is not None:
            found.append(stream)
        return True if seen > _OBJECTS_MAX else None

    root = _stream("/", file)
    if root is not None:
        found.append(root)
    file.visititems(visit)
    return found


def _stream(name: str, thing: Any) -> Stream | None:
    if isinstance(thing, h5py.Group):
        names = columns_of(tuple(k for k, v in thing.items() if isinstance(v, h5py.Dataset)))
        if names is None:
            return None
        columns = {column: thing[names[column]] for column in NAMES}
        return Stream(name, columns, lambda _, rows: rows) if _in_step(columns) else None
    fields = columns_of(thing.dtype.names) if thing.dtype.names else None
    if fields is not None and thing.ndim == 1:
        return Stream(name, dict.fromkeys(NAMES, thing), lambda column, rows: rows[fields[column]])
    if name.split("/")[-1] == "events" and thing.ndim == 2 and thing.shape[1] == 4:
        at = {column: i for i, column in enumerate("xytp")}
        return Stream(name, dict.fromkeys(NAMES, thing), lambda column, rows: rows[:, at[column]])
    return None


def _in_step(columns: dict[str, Any]) -> bool:
    return all(data.ndim == 1 for data in columns.values())


def _check(path: Path, stream: Stream) -> None:
    lengths = {name: data.shape[0] for name, data in stream.columns.items()}
    if len(set(lengths.values())) > 1:
        counts = ", ".join(f"{count} {name}" for name, count in lengths.items())
        raise FormatError(
            f"{path} holds {counts} in {stream.name}; these must be as many; repair it"
        )
    for name, data in stream.columns.items():
        _check_filters(path, data)
        rows = data.chunks[0] if data.chunks else data.shape[0]
        missing = data.size > 0 and data.id.get_storage_size() == 0
        if data.chunks:
            missing = data.id.get_num_chunks() * rows < data.shape[0]
        if missing:
            raise FormatError(
                f"{path} promises {data.shape[0]} events in {stream.name} and does not hold all "
                f"({name}); it was cut; copy it again from where it was made"
            )


def _check_filters(path: Path, data: Any) -> None:
    plist = data.id.get_create_plist()
    for i in range(plist.get_nfilters()):
        code = plist.get_filter(i)[0]
        if code in _BUILT_IN or h5py.h5z.filter_avail(code):
            continue
        if code == _ECF:
            raise FormatError(
                f"{path} is compressed by Prophesee's ECF, for which HDF5 has no plugin here; "
                "install their hdf5_ecf and set HDF5_PLUGIN_PATH, or give the RAW file"
            )
        raise MissingLibraryError("hdf5plugin", f"{path}, compressed by HDF5's filter {code},")


def _offset_us(file: Any) -> int:
    offset = file.get("t_offset")
    with suppress(TypeError, ValueError):
        return int(offset[()]) if isinstance(offset, h5py.Dataset) else 0
    return 0


def _size(file: Any, stream: Stream) -> Size | None:
    """Sensor's size where one of the layouts keeps it."""
    holder = file[stream.name]
    group = holder if isinstance(holder, h5py.Group) else holder.parent
    for thing in (holder, group, file):
        attributes = dict(thing.attrs)
        with suppress(KeyError, TypeError, ValueError, IndexError):
            return int(attributes["width"]), int(attributes["height"])
        with suppress(KeyError, TypeError, ValueError, IndexError):
            rows, columns = (int(side) for side in attributes["sensor_resolution"][:2])
            return columns, rows
        with suppress(KeyError, TypeError, ValueError, IndexError):
            sides = _words(attributes["geometry"]).lower().split("x")
            return int(sides[0]), int(sides[1])
    with suppress(KeyError, TypeError, ValueError, IndexError):
        width, height = (int(side) for side in group["calib/resolution"][:2])
        return width, height
    return None


def _words(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def _items(path: Path, stream: Stream, options: Options) -> Iterator[Item]:
    count = stream.columns["t"].shape[0]
    rows = max(_BLOCK, *(data.chunks[0] if data.chunks else 0 for data in stream.columns.values()))
    widest = max(
        data.dtype.itemsize * int(np.prod(data.shape[1:], dtype=np.int64))
        for data in stream.columns.values()
    )
    rows = max(min(rows, _BLOCK_BYTES_MAX // widest), 1)
    for start in range(0, count, rows):
        blocks: dict[int, Array] = {}
        columns = {}
        for name, data in stream.columns.items():
            try:
                if id(data) not in blocks:
                    blocks[id(data)] = data[start : start + rows]
            except (OSError, RuntimeError, ValueError) as error:
                raise FormatError(
                    f"{path} is damaged in {stream.name} between events {start} and "
                    f"{min(start + rows, count)} ({_first_line(error)}); copy it again"
                ) from error
            columns[name] = stream.take(name, blocks[id(data)])
        t = microseconds(columns["t"], options.time_unit or _unit(stream), path=path)
        yield Columns(t, columns["x"], columns["y"], columns["p"])


def _unit(stream: Stream) -> str | None:
    attributes = stream.columns["t"].attrs
    unit = _words(attributes.get("unit", attributes.get("units", ""))).replace("µ", "u")
    return unit if unit in ("s", "ms", "us", "ns") else None


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__
