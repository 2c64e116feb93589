"""Events as an HDF5 file in the layout of the DSEC data set (Gehrig et al. 2021)."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np

from emulator import EVENT_DTYPE, Events

CHUNK = 1 << 16
_DTYPES = {"t": np.int64, "x": np.uint16, "y": np.uint16, "p": np.uint8}


def read_events(path: Path) -> Events:
    """All events of a file that `DsecWriter` wrote, as `EVENT_DTYPE`."""
    with h5py.File(path) as file:
        events = np.empty(file["events/t"].size, EVENT_DTYPE)
        for name in _DTYPES:
            events[name] = file["events"][name][:]
    return events


class DsecWriter:
    """Appends events to `events/{t,x,y,p}`, compressed by gzip, with the index `ms_to_idx`.

    Use as a context manager; the index is written at the end.
    """

    def __init__(self, path: Path, *, width: int, height: int) -> None:
        self._file = h5py.File(path, "w")
        self._file.attrs["width"], self._file.attrs["height"] = width, height
        group = self._file.create_group("events")
        self._columns = {name: _column(group, name, dtype) for name, dtype in _DTYPES.items()}
        self._file["t_offset"] = np.int64(0)
        self._buffer: list[Events] = []
        self._buffered = 0
        self._per_ms = np.zeros(0, np.int64)

    def __enter__(self) -> DsecWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None:
            self._flush()
            index = np.concatenate([[0], np.cumsum(self._per_ms)])
            self._file["ms_to_idx"] = index.astype(np.uint64)
        self._file.close()

    def write(self, events: Events) -> None:
        """Append events, sorted by t and not older than the last."""
        if not events.size:
            return
        self._buffer.append(events)
        self._buffered += events.size
        if self._buffered >= CHUNK:
            self._flush()

    def _flush(self) -> None:
        if not self._buffer:
            return
        events = np.concatenate(self._buffer)
        self._buffer, self._buffered = [], 0
        for name, column in self._columns.items():
            column.resize(column.size + events.size, axis=0)
            column[-events.size :] = events[name]
        counts = np.bincount(events["t"] // 1000, minlength=self._per_ms.size)
        counts[: self._per_ms.size] += self._per_ms
        self._per_ms = counts


def _column(group: Any, name: str, dtype: type) -> Any:
    return group.create_dataset(
        name, (0,), dtype, maxshape=(None,), chunks=(CHUNK,), compression="gzip", shuffle=True
    )
