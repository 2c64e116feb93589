"""Pixels that show only noise: their events are no more simultaneous than by chance.

Frames cannot tell them alone: lamps flicker and reflections move between frames, and a recording
may have no frames. The events themselves can. The sensor is divided into blocks of 8×8 pixels, and
time into bins of 5 ms. Edges, reflections and lamps make pixels of a block fire together. Noise of
n events per block and polarity in m bins gives n²/(2m) pairs in the same bin, whatever its rate.
A block beside one with a signal is not quiet either, because the signal may reach into it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.ndimage import binary_erosion

from flybench.events import Events
from flybench.kernels import compiled

BLOCK_PX = 8
"""Side of the blocks [px] (assumed)."""
BIN_US = 5_000
"""Duration of the bins [µs] (assumed: half a period of lamps on the mains at 100 Hz)."""
_EXCESS = 0.25
"""Share by which pairs may exceed chance, because noise is not quite steady (assumed)."""
_DEVIATIONS = 3.0
"""Standard deviations that are allowed besides (assumed)."""
_ONE_PAIR = 1.0
"""A single pair proves nothing."""

B1 = npt.NDArray[np.bool_]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]


class SimultaneousPairs:
    """Number of simultaneous pairs in each block and polarity, updated block by block of events.

    A pixel counts once in each bin, so that its own bursts are no pairs.
    """

    def __init__(self, *, width: int, height: int) -> None:
        self._size = height, width
        blocks = (2, -(-height // BLOCK_PX), -(-width // BLOCK_PX))
        self._pixel_bin = np.full((2, height, width), -1, np.int64)
        self._block_bin = np.full(blocks, -1, np.int64)
        self._in_bin, self._events, self._pairs = (np.zeros(blocks, np.int64) for _ in range(3))

    def add(self, events: Events) -> None:
        """Include events, sorted by time and none older than those before."""
        counters = self._in_bin, self._events, self._pairs
        _add(events, self._pixel_bin, self._block_bin, counters)

    def quiet_pixels(self, span_us: int) -> B1:
        """Return (rows, columns) True at pixels that show only noise.

        Args:
            span_us: duration of the recording, above 0 [µs].
        """
        is_noise = self._pairs <= most_pairs(self._events, span_us / BIN_US)
        quiet = binary_erosion(is_noise[0] & is_noise[1], np.ones((3, 3)), border_value=1)
        rows, columns = (np.arange(side) // BLOCK_PX for side in self._size)
        return np.asarray(quiet[np.ix_(rows, columns)])


def most_pairs(events: I64, bins: float) -> F64:
    """Return the number of simultaneous pairs up to which events may be noise.

    Args:
        events: number of events.
        bins: number of bins of the recording.
    """
    by_chance = events.astype(np.float64) ** 2 / (2.0 * bins)
    limit: F64 = (1.0 + _EXCESS) * by_chance + _DEVIATIONS * np.sqrt(by_chance) + _ONE_PAIR
    return limit


@compiled
def _add(events: Any, pixel_bin: Any, block_bin: Any, counters: Any) -> None:
    in_bin, counted, pairs = counters
    for n in range(events.size):
        event = events[n]
        p, y, x, now = int(event.p), event.y, event.x, event.t // BIN_US
        if pixel_bin[p, y, x] == now:
            continue
        pixel_bin[p, y, x] = now
        j, i = y // BLOCK_PX, x // BLOCK_PX
        if block_bin[p, j, i] != now:
            block_bin[p, j, i], in_bin[p, j, i] = now, 0
        pairs[p, j, i] += in_bin[p, j, i]
        in_bin[p, j, i] += 1
        counted[p, j, i] += 1
