"""Averaged time surfaces: the events of a moving window, as one value per cell and polarity."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from detector.errors import StateError
from detector.fly.config import FlyConfig
from detector.fly.event_histogram import (
    NEWEST,
    NOW,
    OLDEST,
    ORIGIN,
    PENDING,
    PIXEL_MASK,
    add_to_histogram,
    merge_equal,
    origin_age_us,
    weight_table,
)
from detector.fly.histogram import averaged_histogram
from detector.fly.model_variants import SurfaceEvents
from detector.fly.surface_history import SurfaceHistory
from flybench.events import Events
from flybench.memory import check_memory, count_memory

F32 = npt.NDArray[np.float32]

_FIRST_CAPACITY = 1 << 12
"""Entries that the ring buffer holds at first; it doubles when a window has more."""
_CROWD = 64
"""Mean number of events of one time stamp above which merging is tried (assumed: above that of real
sensors, because sorting the buffer takes longer than filling it)."""
_ENTRY_BYTES, _GROWTH_BYTES = 20, 80
"""Memory per entry of the ring buffer, and per entry of the old one while it grows [bytes]."""

_ARRAYS = ("totals", "times", "pixels", "merged", "clock", "tallies", "surfaces", "has_surface")
"""Arrays of `TimeSurfaces` that belong to its state."""


class TimeSurfaces(SurfaceHistory):
    """Accumulates events hop by hop and averages them over windows (equations 2 to 8).

    A hop is the step between estimates. For each hop of a window, every cell and polarity has a
    tally: the sum of its events' surfaces, and their number. A window is the sum of its hops.
    Averaged surfaces are kept for the longest delay.

    Attributes:
        origin_px: corner of the first cell, (x, y) on the sensor [px].
    """

    origin_px = 0, 0

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
        super().__init__(config, grid=(self.rows, self.columns))
        self._origin_age_us = origin_age_us(config.tau_us)
        self._parameters = (
            config.window_us,
            self._origin_age_us,
            config.neighbourhood_px,
            config.time_surface is SurfaceEvents.ITSELF,
            width,
            weight_table(config.tau_us),
            np.concatenate([np.arange(width) // side, np.arange(height) // side * self.columns]),
        )
        self._totals = np.zeros(2 * height * width)
        grid = 2, self.rows, self.columns
        self._tallies = np.zeros((config.window_hops, *grid, 2))
        self._clock = np.zeros(5, np.int64)
        self.forget()

    @property
    def is_fresh(self) -> bool:
        """True if no event has come yet, or none since everything was forgotten."""
        return not self._clock[NEWEST]

    @property
    def last_event_us(self) -> int:
        """Time of the last event [µs]; 0 before the first."""
        return int(self._clock[NOW])

    @property
    def memory_bytes(self) -> int:
        """Size of the ring buffer of the last Δt's events; it does not grow with the stream."""
        return self._times.nbytes + self._pixels.nbytes + self._merged.nbytes

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Return copies of everything that changes, as arrays by name."""
        state = {name: getattr(self, f"_{name}").copy() for name in _ARRAYS}
        return state | {"hop_events": np.array(self._hop_events), "slot": np.array(self._slot)}

    def restore(self, state: dict[str, npt.NDArray[Any]], *, now_us: int) -> None:
        """Continue from a `state` of surfaces with the same configuration and sensor.

        Args:
            state: candidate.
            now_us: time that the stream has reached [µs].

        Raises:
            StateError: the ring buffer or the clock contradicts itself.
        """
        times, pixels, clock = state["times"], state["pixels"], state["clock"]
        kept = clock[NEWEST] - clock[OLDEST]
        is_ring = times.size == pixels.size > 0 and times.size & (times.size - 1) == 0
        is_ordered = 0 <= clock[OLDEST] <= clock[PENDING] <= clock[NEWEST]
        merged = state["merged"]
        is_inside = (
            is_ring
            and pixels.min() >= -merged.size
            and pixels.max() < self._totals.size
            and (merged >= 0).all()
            and ((merged & PIXEL_MASK) < self._totals.size).all()
        )
        if not (is_inside and is_ordered and kept <= times.size):
            raise StateError(
                f"The state keeps {kept} events in a buffer of {times.size}, and its bounds "
                f"{clock[OLDEST:].tolist()} do not fit. Pass everything that "
                "FlyDetector.state() returned, unchanged."
            )
        self._check_clock(times, clock, now_us)
        for name in _ARRAYS:
            setattr(self, f"_{name}", np.ascontiguousarray(state[name]).copy())
        self._hop_events = state["hop_events"].tolist()
        self._slot = int(state["slot"]) % len(self._hop_events)

    def _check_clock(
        self, times: npt.NDArray[np.int64], clock: npt.NDArray[np.int64], now_us: int
    ) -> None:
        """Refuse a clock that is ahead of the stream, or events out of order."""
        last_us, origin_us, oldest, _, newest = clock.tolist()
        kept = times[np.arange(oldest, newest) % times.size]
        in_order = np.concatenate([[origin_us], kept, [last_us]])
        greatest_age_us = max(self._origin_age_us, self._config.window_us)
        if (
            not (0 <= last_us <= now_us and last_us - origin_us <= greatest_age_us)
            or (np.diff(in_order) < 0).any()
        ):
            raise StateError(
                f"The last event of the state is at {last_us} µs, and its first at "
                f"{int(in_order[:2].max())} µs. Allowed are times in order, up to {now_us} µs. "
                "Pass everything that FlyDetector.state() returned, unchanged."
            )

    def forget(self) -> None:
        """Return to the initial state: later events give the bits that a new instance gives."""
        for array in (self._totals, self._tallies, self._surfaces, self._has_surface, self._clock):
            array[...] = 0
        self._clock[ORIGIN] = -self._config.window_us
        self._times = np.zeros(_FIRST_CAPACITY, np.int64)
        self._pixels = np.zeros(_FIRST_CAPACITY, np.int32)
        self._merged = np.zeros(0, np.int64)
        count_memory(self, "A new fly", _FIRST_CAPACITY * _ENTRY_BYTES)
        self._hop_events = [0] * self._config.window_hops
        self._slot = 0

    def begin_hop(self, hop: int) -> None:
        """Replace the oldest hop of the window by hop number `hop`, without events."""
        self._slot = hop % len(self._hop_events)
        if self._hop_events[self._slot]:
            self._tallies[self._slot] = 0.0
            self._hop_events[self._slot] = 0

    def accumulate(self, events: Events, start: int, *, until_us: int) -> int:
        """Add the events before `until_us` to the hop that was begun last.

        Args:
            events: checked and sorted; none earlier than one that was added before.
            start: index of the first event to add.
            until_us: end of the hop, exclusive [µs].

        Returns:
            Index of the first event that was not added because it belongs to a later hop.
        """
        taken = self._add(events, start, until_us)
        while taken < 0:
            self._make_room()
            taken = self._add(events, -1 - taken, until_us)
        self._hop_events[self._slot] += taken - start
        return taken

    def _add(self, events: Events, start: int, until_us: int) -> int:
        ring = self._times, self._pixels, self._merged
        memory = self._totals, *ring, self._clock, self._tallies
        return add_to_histogram(events, start, until_us, self._parameters, memory, self._slot)

    def average(self, *, hop: int) -> F32:
        """Assemble the averaged histograms of the window that ends with a hop (equation 8).

        Args:
            hop: number of the hop that was begun last.

        Returns:
            (2, rows, columns) float32, dimensionless: OFF surface, ON surface. `averaged` returns
            it again until the longest delay is over.
        """
        if not any(self._hop_events):
            return self._keep(hop, None)
        surface = averaged_histogram(
            self._tallies,
            oldest=(hop + 1) % len(self._tallies),
            averaging=self._config.averaging,
            cell_area=self._config.cell_px**2,
        )
        return self._keep(hop, surface)

    def _make_room(self) -> None:
        """Merge equal entries of the full ring buffer; double it if that does not free half of it.

        Raises:
            MemoryBudgetError: the events of the window do not fit into the memory budget.
        """
        size, oldest = self._times.size, int(self._clock[OLDEST])
        what = f"A window with {size} events of different time or pixel"
        check_memory(what, size * _GROWTH_BYTES, owner=self)
        order = np.arange(oldest, self._clock[NEWEST]) % size
        times, pixels, merged = self._times[order], self._pixels[order], self._merged
        if np.count_nonzero(np.diff(times)) < size // _CROWD:
            times, pixels, merged = merge_equal(times, pixels, merged)
            self._clock[NEWEST] = oldest + times.size
            self._clock[PENDING] = oldest + np.searchsorted(times, self._clock[NOW])
        if times.size > size // 2:
            size *= 2
            count_memory(self, what, size * _ENTRY_BYTES)
        self._times, self._pixels = np.zeros(size, np.int64), np.zeros(size, np.int32)
        order = np.arange(oldest, oldest + times.size) % size
        self._times[order], self._pixels[order], self._merged = times, pixels, merged
