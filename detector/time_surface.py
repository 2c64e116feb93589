"""Averaged time surfaces: the events of a moving window, as one value per cell and polarity.

The sum of equation 2 is kept for every pixel and polarity as a running total W of weights
e^(t_j / τ) in a common unit, so that an event's surface is W · e^(−t_i / τ): one addition when an
event comes and one subtraction when it leaves the window, however many lie in between. Two facts
keep the running total true. An event that leaves is the oldest and so weighs least, hence the
subtraction cancels no digits that matter; and a pixel left by its last event is set to zero. The
operations on a pixel follow from the event times alone, so the cuts between chunks change no bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from detector.fly_config import FlyConfig
from detector.histogram import averaged_histogram, window_sums
from emulator.events import Events

F32 = npt.NDArray[np.float32]

_PIXEL_DTYPE = np.dtype([("weight", "<f8"), ("live", "<i8")])
"""weight: W; live: how many events make it up."""

_MEMORY_DTYPE = np.dtype([("t", "<i8"), ("weight", "<f8"), ("pixel", "<i8")])
"""An event of the last Δt: its time [µs], its weight e^(t / τ), and whose total it joins."""

_CLOCK_DTYPE = np.dtype(
    [
        ("now_us", "<i8"),
        ("unit_us", "<i8"),
        ("growth", "<f8"),
        ("oldest", "<i8"),
        ("pending", "<i8"),
        ("newest", "<i8"),
    ]
)
"""Where the stream stands. growth: e^((now − unit) / τ), the weight of an event now; oldest,
pending, newest: bounds in the memory of the events that count already, and of those of this very
microsecond, which must not see one another."""

_UNIT_SPAN = 300.0
"""How many τ the unit of the weights may age before it is renewed: e^300 is far from overflow."""

_BLOCK = 1 << 16
"""Events a kernel call takes at most; bounds the memory whatever the chunk."""


class TimeSurfaces:
    """Accumulates events hop by hop and averages them over windows (equations 2 to 8).

    A hop is the step between estimates. For each hop of a window and of the delay before it, every
    cell and polarity keeps the sum of its events' surfaces and their number; a window is the sum of
    its hops.
    """

    def __init__(self, config: FlyConfig, *, width: int, height: int) -> None:
        """Start empty, at time 0.

        Args:
            config: windows, decay and cells.
            width: sensor columns [px].
            height: sensor rows [px].
        """
        self._config = config
        side = config.cell_px
        self.rows, self.columns = -(-height // side), -(-width // side)
        self._row_of_y, self._column_of_x = np.arange(height) // side, np.arange(width) // side
        self._pixels = np.zeros((2, height, width), _PIXEL_DTYPE)
        self._memory = np.zeros(2 * _BLOCK, _MEMORY_DTYPE)
        self._clock = np.zeros(1, _CLOCK_DTYPE)
        self._clock["growth"] = 1.0
        hops_kept = config.window_hops + config.delay_hops
        self._sums = np.zeros((hops_kept, 2, self.rows, self.columns))
        self._counts = np.zeros((hops_kept, 2, self.rows, self.columns), np.int64)
        self._hop_events = [0] * hops_kept

    @property
    def is_quiet(self) -> bool:
        """Whether no event fell into any of the hops kept."""
        return not any(self._hop_events)

    @property
    def memory_bytes(self) -> int:
        """Size of the memory of the last Δt's events: follows their number, not the stream's."""
        return self._memory.nbytes

    def begin_hop(self, hop: int) -> None:
        """Forget the oldest hop kept and start hop number `hop` in its place."""
        slot = hop % len(self._hop_events)
        if self._hop_events[slot]:
            self._sums[slot] = 0.0
            self._counts[slot] = 0
            self._hop_events[slot] = 0

    def accumulate(self, events: Events, *, hop: int, until_us: int) -> int:
        """Add the events before `until_us` to the hop that was begun last.

        Args:
            events: checked and sorted, none older than one added before.
            hop: number of the hop that the events belong to.
            until_us: end of the hop, exclusive [µs].

        Returns:
            How many events were taken from the front.
        """
        slot = hop % len(self._hop_events)
        taken = 0
        while taken < events.size:
            block = events[taken : taken + _BLOCK]
            self._make_room(block.size)
            used = _histogram(
                block,
                until_us,
                float(self._config.tau_us),
                self._config.window_us,
                self._config.neighbourhood_px,
                self._row_of_y,
                self._column_of_x,
                self._pixels,
                self._memory,
                self._clock,
                self._sums[slot],
                self._counts[slot],
            )
            taken += used
            if used < block.size:
                break
        self._hop_events[slot] += taken
        return taken

    def average(self, *, hop: int) -> F32:
        """Assemble the averaged histograms of the window that ends with a hop (equation 8).

        Args:
            hop: number of the window's last hop; this one, or any whose window is still kept.

        Returns:
            (2, rows, columns) float32, dimensionless: OFF surface, ON surface.
        """
        hops = np.arange(hop - self._config.window_hops + 1, hop + 1) % len(self._hop_events)
        sums, counts = window_sums(self._sums, self._counts, hops)
        return averaged_histogram(
            sums, counts, averaging=self._config.averaging, cell_area=self._config.cell_px**2
        )

    def _make_room(self, incoming: int) -> None:
        """Let the memory of the last Δt hold `incoming` events more."""
        oldest, newest = int(self._clock["oldest"][0]), int(self._clock["newest"][0])
        size = self._memory.size
        if newest - oldest + incoming <= size:
            return
        larger = np.zeros(2 * size, _MEMORY_DTYPE)
        numbers = np.arange(oldest, newest)
        larger[numbers % larger.size] = self._memory[numbers % size]
        self._memory = larger


@njit(cache=True)
def _histogram(
    events: Any,
    until_us: int,
    tau_us: float,
    window_us: int,
    neighbourhood_px: int,
    row_of_y: Any,
    column_of_x: Any,
    pixels: Any,
    memory: Any,
    clocks: Any,
    sums: Any,
    counts: Any,
) -> int:
    """Histogram of each cell (paper, equation 4), of the events before `until_us`; their number."""
    clock = clocks[0]
    _, height, width = pixels.shape
    totals = pixels.reshape(-1)
    for n in range(events.size):
        event = events[n]
        t, x, y, q = event.t, event.x, event.y, int(event.p)
        if t >= until_us:
            return n
        if t != clock.now_us:
            _move_window(t, tau_us, window_us, totals, memory, clock)
        pixel = (q * height + y) * width + x
        row, column = row_of_y[y], column_of_x[x]
        sums[q, row, column] += _time_surface(pixels[q], x, y, neighbourhood_px, clock.growth)
        counts[q, row, column] += 1
        entry = memory[clock.newest & (memory.size - 1)]
        entry.t, entry.weight, entry.pixel = t, clock.growth, pixel
        clock.newest += 1
    return int(events.size)


@njit(cache=True)
def _time_surface(plane: Any, x: int, y: int, radius: int, growth: float) -> float:
    """Time surface of an event at a pixel (paper, equation 2), summed over z (equation 3)."""
    if radius == 0:
        return float(plane[y, x].weight / growth)
    total = 0.0
    for row in range(max(y - radius, 0), min(y + radius + 1, plane.shape[0])):
        for column in range(max(x - radius, 0), min(x + radius + 1, plane.shape[1])):
            total += plane[row, column].weight
    return total / growth


@njit(cache=True)
def _move_window(
    t: int, tau_us: float, window_us: int, totals: Any, memory: Any, clock: Any
) -> None:
    """Let the totals hold exactly the events in [t − Δt, t) (paper, equations 2 and 3)."""
    wrap = memory.size - 1
    for k in range(clock.pending, clock.newest):
        entry = memory[k & wrap]
        total = totals[entry.pixel]
        total.weight += entry.weight
        total.live += 1
    clock.pending = clock.newest
    while clock.oldest < clock.newest and memory[clock.oldest & wrap].t < t - window_us:
        entry = memory[clock.oldest & wrap]
        total = totals[entry.pixel]
        total.live -= 1
        total.weight = total.weight - entry.weight if total.live else 0.0
        clock.oldest += 1
    if t - clock.unit_us > _UNIT_SPAN * tau_us:
        factor = np.exp((clock.unit_us - t) / tau_us)
        for k in range(totals.size):
            totals[k].weight *= factor
        for k in range(clock.oldest, clock.newest):
            memory[k & wrap].weight *= factor
        clock.unit_us = t
    clock.now_us = t
    clock.growth = np.exp((t - clock.unit_us) / tau_us)
