"""Events as an HDF5 file in the layout of the DSEC data set (Gehrig et al. 2021)."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from flybench.events import Events, concatenate_events
from formats.errors import FormatError
from formats.writers.base import EventWriter
from formats.writers.lasting_file import LastingFile

CHUNK = 1 << 16
LATEST_US = 86_400_000_000
"""Latest time, one day (assumed): the index then has 86 million entries [µs]."""

_DTYPES = {"t": np.int64, "x": np.uint16, "y": np.uint16, "p": np.uint8}


class DsecWriter(EventWriter):
    """Writes the data sets `events/{t,x,y,p}`, compressed with gzip, and the index `ms_to_idx`."""

    _index_end_us = 0

    def index_until(self, t_us: int) -> None:
        """Make the index reach a time, even if the last event is earlier.

        Readers that look up a window by its end need this. Without it, the index ends with the
        millisecond after the last event.

        Args:
            t_us: time up to which windows may be looked up, at most one day [µs].
        """
        self._index_end_us = min(t_us, LATEST_US)

    def _open(self, work: Path) -> None:
        self._disk = LastingFile(work)
        self._file = h5py.File(self._disk, "w")
        self._file.attrs["width"], self._file.attrs["height"] = self.width, self.height
        group = self._file.create_group("events")
        self._columns = {name: _column(group, name, dtype) for name, dtype in _DTYPES.items()}
        self._file["t_offset"] = np.int64(0)
        self._buffer: list[Events] = []
        self._buffered = 0
        self._index = _column(self._file, "ms_to_idx", np.uint64)

    def _write(self, events: Events) -> None:
        if int(events["t"][-1]) > LATEST_US:
            raise FormatError(
                f"{self.path}: an event has the time {events['t'][-1]} µs. Allowed is up to "
                f"{LATEST_US} µs, because the index of DSEC has one entry per millisecond. "
                "Subtract the time of the first event."
            )
        self._buffer.append(concatenate_events([events]))  # a copy: the caller may change it
        self._buffered += events.size
        if self._buffered >= CHUNK:
            self._flush()

    def _finish(self) -> None:
        self._flush()
        end = max(-(-self._index_end_us // 1000), self._index.size) + 1
        for first in range(self._index.size, end, CHUNK):
            entries = min(CHUNK, end - first)
            self._append(self._index, np.full(entries, self._columns["t"].size))
        self._file.close()
        self._disk.check()

    def _abandon(self) -> None:
        with suppress(AttributeError):
            self._file.close()
            self._disk.close()

    def _flush(self) -> None:
        if not self._buffer:
            return
        events = concatenate_events(self._buffer)
        self._buffer, self._buffered = [], 0
        self._extend_index(events["t"])
        for name, column in self._columns.items():
            self._append(column, events[name])
        self._disk.check()

    def _extend_index(self, t: npt.NDArray[np.int64]) -> None:
        """Append the number of events before each millisecond, up to that of the last event."""
        before, end = self._columns["t"].size, int(t[-1]) // 1000 + 1
        for first in range(self._index.size, end, CHUNK):
            ms = np.arange(first, min(first + CHUNK, end))
            self._append(self._index, before + np.searchsorted(t, ms * 1000))

    @staticmethod
    def _append(column: Any, values: npt.NDArray[Any]) -> None:
        column.resize(column.size + values.size, axis=0)
        column[-values.size :] = values


def _column(group: Any, name: str, dtype: type) -> Any:
    return group.create_dataset(
        name,
        (0,),
        dtype,
        maxshape=(None,),
        chunks=(CHUNK,),
        compression="gzip",
        compression_opts=1,
        shuffle=True,
    )
