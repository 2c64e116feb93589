"""CSV, and text with one event per line (Event Camera Dataset, Mueggler et al. 2017)."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from flybench.events import Events
from formats.errors import MissingLibraryError
from formats.writers.base import EventWriter


class TextWriter(EventWriter):
    """Writes the width and height of the sensor, then lines `t x y p` with t in s, 6 decimals."""

    _separator = " "

    def _open(self, work: Path) -> None:
        try:
            import pyarrow
            from pyarrow import csv
        except ImportError:
            raise MissingLibraryError("pyarrow", "writing text and CSV") from None
        self._arrow, self._csv = pyarrow, csv
        self._file = work.open("wb")
        self._file.write(self._first_line().encode())
        self._options = self._csv.WriteOptions(include_header=False, delimiter=self._separator)

    def _first_line(self) -> str:
        return f"{self.width} {self.height}\n"

    def _time(self, t_us: np.ndarray[tuple[int], np.dtype[np.int64]]) -> Any:
        pa = self._arrow
        words = np.stack([t_us, np.zeros_like(t_us)], axis=1)  # 128 bits, little-endian
        return pa.Array.from_buffers(pa.decimal128(38, 6), t_us.size, [None, pa.py_buffer(words)])

    def _write(self, events: Events) -> None:
        pa = self._arrow
        columns = {name: pa.array(np.ascontiguousarray(events[name])) for name in "xy"}
        p = pa.array(events["p"].astype(np.uint8))
        table = pa.table({"t": self._time(np.ascontiguousarray(events["t"])), **columns, "p": p})
        self._csv.write_csv(table, self._file, self._options)

    def _finish(self) -> None:
        self._file.close()

    def _abandon(self) -> None:
        with suppress(AttributeError):
            self._file.close()


class CsvWriter(TextWriter):
    """Writes a comment with width and height, the header `t,x,y,p`, then events with t in µs."""

    _separator = ","

    def _first_line(self) -> str:
        return f"# {self.width} {self.height}\nt,x,y,p\n"

    def _time(self, t_us: np.ndarray[tuple[int], np.dtype[np.int64]]) -> Any:
        return self._arrow.array(t_us)
