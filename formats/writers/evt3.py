"""Prophesee RAW, EVT 3.0: one 16-bit word for each part of an event that changes.

flybench has its own encoder because that of faery 0.7.1 does not mark the overflow of the 24-bit
clock, so that events after 17 s are read back too early.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from flybench.events import Events
from formats.writers.base import EventWriter

_Y, _X, _TIME_LOW, _TIME_HIGH = 0x0000, 0x2000, 0x6000, 0x8000
"""Types of words: the highest 4 bits."""

_LOW_BITS = 12
_MASK = (1 << _LOW_BITS) - 1
_TICK = 16
"""Largest step of the high word of the time, 66 ms.

A decoder may take a longer step for an error (measured: faery's decoder drops one of half the
clock's period).
"""

_BLOCK = 1 << 16


class Evt3Writer(EventWriter):
    """Writes a RAW file: addresses of 11 bits, and a clock of 24 bits that overflows."""

    max_side_px: ClassVar[int] = 2048

    def _open(self, work: Path) -> None:
        self._file = work.open("wb")
        geometry = f"height={self.height};width={self.width}"
        self._file.write(
            f"% camera_integrator_name flybench\n% evt 3.0\n% format EVT3;{geometry}\n"
            f"% geometry {self.width}x{self.height}\n% end\n".encode()
        )
        self._high = 0
        self._low = self._row = -1
        self._file.write(np.array([_TIME_HIGH], "<u2").tobytes())

    def _write(self, events: Events) -> None:
        high = events["t"] >> _LOW_BITS
        overflows = np.diff(high >> _LOW_BITS, prepend=self._high >> _LOW_BITS) > 0
        breaks = np.flatnonzero(overflows | (np.diff(high, prepend=self._high) > _TICK))
        start = 0
        for i in breaks.tolist():
            self._put(events[start:i], high[start:i])
            self._pass_time(int(high[i]))
            start = i
        self._put(events[start:], high[start:])

    def _pass_time(self, high: int) -> None:
        """Write the time words that a camera sends while nothing happens."""
        while self._high // _TICK < high // _TICK:
            first = self._high // _TICK + 1
            ticks = _TICK * np.arange(first, min(high // _TICK + 1, first + _BLOCK))
            before_overflows = ticks[(ticks & _MASK) == 0] - 1
            ticks = np.sort(np.append(ticks, before_overflows))
            self._file.write((_TIME_HIGH | (ticks & _MASK)).astype("<u2").tobytes())
            self._high = int(ticks[-1])
        self._low = -1

    def _put(self, events: Events, high: npt.NDArray[np.int64]) -> None:
        """Write events between which the clock neither overflows nor steps by more than `_TICK`."""
        if not events.size:
            return
        low = events["t"] & _MASK
        row = events["y"].astype(np.int64)
        new_high = np.diff(high, prepend=self._high) != 0
        new_low = (np.diff(low, prepend=self._low) != 0) | new_high
        words = np.empty((events.size, 4), "<u2")
        words[:, 0] = _TIME_HIGH | (high & _MASK)
        words[:, 1] = _TIME_LOW | low
        words[:, 2] = _Y | row
        words[:, 3] = _X | (events["p"].astype(np.int64) << 11) | events["x"]
        new_row = np.diff(row, prepend=self._row) != 0
        needed = np.stack([new_high, new_low, new_row, np.ones_like(new_low)], axis=1)
        self._file.write(words[needed].tobytes())
        self._high, self._low, self._row = int(high[-1]), int(low[-1]), int(row[-1])

    def _finish(self) -> None:
        self._file.close()

    def _abandon(self) -> None:
        with suppress(AttributeError):
            self._file.close()
