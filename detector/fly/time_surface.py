"""Averaged time surfaces: the events of a moving window, as one value per cell and polarity.

The sum of equation 2 is kept for every pixel and polarity as a running total W of weights
e^((t_j − unit) / τ), so that an event's surface is W over the weight of an event now: one addition
when an event comes and one subtraction when it leaves the window, however many lie in between. An
event that leaves is the oldest and weighs least, hence the subtraction cancels no digits that
matter; and what is left of a pixel's total is either some event that weighs no less, or nothing but
rounding, which is set to zero. The operations on a pixel follow from the event times alone, so the
cuts between chunks change no bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from detector.errors import StateError
from detector.fly.config import FlyConfig
from detector.fly.histogram import averaged_histogram
from detector.fly.model_variants import TimeSurface
from flybench.events import Events
from flybench.kernels import compiled, inlined

F32 = npt.NDArray[np.float32]

_NOW, _UNIT, _OLDEST, _PENDING, _NEWEST = range(5)
"""Where the stream stands: time reached and start of the unit [µs], and bounds in the memory of
the events that count already and of those of this very microsecond, which must not see one
another."""

_UNIT_SPAN_TAUS = 300
"""How many τ the unit of the weights may age before it is renewed: e^300 is far from overflow."""

_TABLE_BITS = 12
_TABLE_SIZE = 1 << _TABLE_BITS
_UNIT_SPAN_US = 1 << 2 * _TABLE_BITS
"""The same in µs: weights come from a table of the low bits and one of the high bits."""

_FIRST_ROOM = 1 << 12
"""Events that the memory holds at first; it doubles when a window has more."""


class TimeSurfaces:
    """Accumulates events hop by hop and averages them over windows (equations 2 to 8).

    A hop is the step between estimates. For each hop of a window, every cell and polarity keeps
    the sum of its events' surfaces and their number; a window is the sum of its hops. Averaged
    surfaces are kept for as long as the longest delay.
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
        span_us = min(_UNIT_SPAN_TAUS * config.tau_us, _UNIT_SPAN_US)
        self._constants = (
            config.window_us,
            span_us,
            config.neighbourhood_px,
            config.time_surface is TimeSurface.ITSELF,
            width,
            _weight_table(span_us, config.tau_us),
            np.concatenate([np.arange(width) // side, np.arange(height) // side * self.columns]),
        )
        self._totals = np.zeros(2 * height * width)
        grid = 2, self.rows, self.columns
        self._tallies = np.zeros((config.window_hops, *grid, 2))
        self._surfaces = np.zeros((max(config.delays_hops) + 1, *grid), np.float32)
        self._has_surface = np.zeros(max(config.delays_hops) + 1, np.bool_)
        self._clock = np.zeros(5, np.int64)
        self.forget()

    @property
    def is_fresh(self) -> bool:
        """Whether no event has come yet, or none since everything was forgotten."""
        return not self._clock[_NEWEST]

    @property
    def is_quiet(self) -> bool:
        """Whether every surface kept is empty."""
        return not self._has_surface.any()

    @property
    def last_event_us(self) -> int:
        """Time of the last event [µs]; 0 while there is none."""
        return int(self._clock[_NOW])

    @property
    def memory_bytes(self) -> int:
        """Size of the memory of the last Δt's events: follows their number, not the stream's."""
        return self._times.nbytes + self._pixels.nbytes

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Everything that changes, as arrays by name; copies."""
        state = {name: getattr(self, f"_{name}").copy() for name in _ARRAYS}
        return state | {"hop_events": np.array(self._hop_events), "slot": np.array(self._slot)}

    def restore(self, state: dict[str, npt.NDArray[Any]], *, now_us: int) -> None:
        """Go on from what `state` of the same configuration and sensor gave.

        Args:
            state: candidate.
            now_us: time that the stream has reached [µs].

        Raises:
            StateError: the memory of events, or the clock, contradicts itself.
        """
        times, pixels, clock = state["times"], state["pixels"], state["clock"]
        kept = clock[_NEWEST] - clock[_OLDEST]
        is_ring = times.size == pixels.size > 0 and times.size & (times.size - 1) == 0
        is_ordered = 0 <= clock[_OLDEST] <= clock[_PENDING] <= clock[_NEWEST]
        is_inside = pixels.min() >= 0 and pixels.max() < self._totals.size if is_ring else False
        if not (is_inside and is_ordered and kept <= times.size):
            raise StateError(
                f"the state keeps {kept} events in a memory of {times.size}, and its bounds "
                f"{clock[2:].tolist()} do not fit; pass what FlyDetector.state() gave, whole"
            )
        self._check_clock(times, clock, now_us)
        for name in _ARRAYS:
            setattr(self, f"_{name}", np.ascontiguousarray(state[name]).copy())
        self._hop_events = state["hop_events"].tolist()
        self._slot = int(state["slot"]) % len(self._hop_events)

    def _check_clock(
        self, times: npt.NDArray[np.int64], clock: npt.NDArray[np.int64], now_us: int
    ) -> None:
        """Refuse a clock ahead of the stream, or kept events that it cannot hold."""
        last_us, unit_us, oldest, _, newest = clock.tolist()
        kept = times[np.arange(oldest, newest) % times.size]
        in_order = np.concatenate([[unit_us], kept, [last_us]])
        span_us = max(self._constants[1], self._config.window_us)
        if (
            not (0 <= last_us <= now_us and last_us - unit_us <= span_us)
            or (np.diff(in_order) < 0).any()
        ):
            raise StateError(
                f"the state's last event is at {last_us} µs, and what it keeps begins at "
                f"{int(in_order[:2].max())} µs; allowed are times in order, up to {now_us} µs; "
                "pass what FlyDetector.state() gave, whole"
            )

    def forget(self) -> None:
        """Be as new: the same events then give the same bits as they give a new one."""
        for array in (self._totals, self._tallies, self._surfaces, self._has_surface, self._clock):
            array[...] = 0
        self._clock[_UNIT] = -self._config.window_us
        self._times = np.zeros(_FIRST_ROOM, np.int64)
        self._pixels = np.zeros(_FIRST_ROOM, np.int32)
        self._hop_events = [0] * self._config.window_hops
        self._slot = 0

    def begin_hop(self, hop: int) -> None:
        """Forget the oldest hop of the window and start hop number `hop` in its place."""
        self._slot = hop % len(self._hop_events)
        if self._hop_events[self._slot]:
            self._tallies[self._slot] = 0.0
            self._hop_events[self._slot] = 0

    def accumulate(self, events: Events, start: int, *, until_us: int) -> int:
        """Add the events before `until_us` to the hop that was begun last.

        Args:
            events: checked and sorted, none older than one added before.
            start: index of the first to take.
            until_us: end of the hop, exclusive [µs].

        Returns:
            Index of the first that was not taken: it belongs to a later hop.
        """
        taken = self._take(events, start, until_us)
        while taken < 0:
            self._make_room()
            taken = self._take(events, -1 - taken, until_us)
        self._hop_events[self._slot] += taken - start
        return taken

    def _take(self, events: Events, start: int, until_us: int) -> int:
        taken: int = _histogram(
            events,
            start,
            until_us,
            *self._constants,
            self._totals,
            self._times,
            self._pixels,
            self._clock,
            self._tallies,
            self._slot,
        )
        return taken

    def average(self, *, hop: int) -> F32:
        """Assemble the averaged histograms of the window that ends with a hop (equation 8).

        Args:
            hop: number of the hop that was begun last.

        Returns:
            (2, rows, columns) float32, dimensionless: OFF surface, ON surface. The same as
            `averaged` gives for this hop until the longest delay is over.
        """
        slot = hop % len(self._surfaces)
        self._has_surface[slot] = any(self._hop_events)
        if self._has_surface[slot]:
            self._surfaces[slot] = averaged_histogram(
                self._tallies,
                oldest=(hop + 1) % len(self._tallies),
                averaging=self._config.averaging,
                cell_area=self._config.cell_px**2,
            )
        else:
            self._surfaces[slot] = 0.0
        return self.averaged(hop=hop)

    def averaged(self, *, hop: int) -> F32:
        """What `average` gave for this hop, at most the longest delay ago; a copy."""
        surface: F32 = self._surfaces[hop % len(self._surfaces)].copy()
        return surface

    def delayed(self, *, hop: int) -> F32:
        """The delayed signal Ĥ of equation 9: the mean surface over the delays before a hop.

        Correlation is linear in it, so that several delays cost no more than one.
        """
        if len(self._config.delays_hops) == 1:
            return self.averaged(hop=hop - self._config.delays_hops[0])
        taps = (np.array(self._config.delays_hops) * -1 + hop) % len(self._surfaces)
        surface: F32 = self._surfaces[taps].mean(axis=0)
        return surface

    def _make_room(self) -> None:
        """Double the memory of the last Δt's events."""
        size = self._times.size
        numbers = np.arange(self._clock[_OLDEST], self._clock[_NEWEST])
        for name in ("_times", "_pixels"):
            old = getattr(self, name)
            larger = np.zeros(2 * size, old.dtype)
            larger[numbers % larger.size] = old[numbers % size]
            setattr(self, name, larger)


_ARRAYS = ("totals", "times", "pixels", "clock", "tallies", "surfaces", "has_surface")


def _weight_table(span_us: int, tau_us: int) -> npt.NDArray[np.float64]:
    """e^(t / τ) for t from 0 to the span, as the product of two parts, one of its low bits first.

    They lie in one array, for each array that a kernel is called with takes its time.
    """
    fine = np.exp(np.arange(_TABLE_SIZE) / tau_us)
    coarse = np.exp(np.arange(0, span_us + 1, _TABLE_SIZE) / tau_us)
    return np.concatenate([fine, coarse])


@compiled
def _histogram(
    events: Any,
    start: int,
    until_us: int,
    window_us: int,
    span_us: int,
    radius: int,
    counts_itself: bool,
    width: int,
    table: Any,
    places: Any,
    totals: Any,
    times: Any,
    pixels: Any,
    clock: Any,
    tallies: Any,
    slot: int,
) -> int:
    """Histogram of each cell (paper, equation 4), of the events before `until_us`.

    The cell of a pixel is the sum of its places, the column's and, after those, the row's.

    Returns the index of the first event not taken; where the memory is full, −1 less that index.
    """
    height = places.size - width
    cells = tallies.shape[2] * tallies.shape[3]
    flat = tallies[slot].reshape(-1)
    wrap = times.size - 1
    now, unit, oldest, pending, newest = clock
    weight = _weight(now - unit, table)
    taken = events.size
    for n in range(start, events.size):
        event = events[n]
        if event.t >= until_us:
            taken = n
            break
        if event.t != now:
            now = event.t
            for k in range(pending, newest):
                totals[pixels[k & wrap]] += weight
            pending = newest
            while oldest < newest and times[oldest & wrap] < now - window_us:
                gone = _weight(times[oldest & wrap] - unit, table)
                totals[pixels[oldest & wrap]] = _rest(totals[pixels[oldest & wrap]], gone)
                oldest += 1
            if now - unit >= span_us:
                unit = _renew_unit(now - window_us, unit, oldest < newest, table, totals)
            weight = _weight(now - unit, table)
        if newest - oldest > wrap:
            taken = -1 - n
            break
        pixel, at = _place(event, width, height, cells, places)
        total = _time_surface(totals, pixel, event.x, event.y, radius, width, height)
        flat[at] += total / weight + counts_itself
        flat[at + 1] += 1.0
        times[newest & wrap], pixels[newest & wrap] = now, pixel
        newest += 1
    clock[:] = now, unit, oldest, pending, newest
    return int(taken)


@inlined
def _place(event: Any, width: int, height: int, cells: int, places: Any) -> Any:
    """Where the event's total and its cell's pair of tallies lie in memory."""
    q = np.int64(event.p)
    cell = q * cells + places[width + event.y] + places[event.x]
    return (q * height + event.y) * width + event.x, 2 * cell


@inlined
def _weight(age_us: int, table: Any) -> float:
    """Weight e^(age / τ) of an event this long after the start of the unit."""
    return float(table[age_us & (_TABLE_SIZE - 1)] * table[_TABLE_SIZE + (age_us >> _TABLE_BITS)])


@inlined
def _time_surface(
    totals: Any, pixel: int, x: int, y: int, radius: int, width: int, height: int
) -> float:
    """Time surface of an event at a pixel (paper, equation 2), summed over z (equation 3).

    In the unit of the weights, so that the weight of an event now has to be divided out.
    """
    if radius == 0:
        return float(totals[pixel])
    total = 0.0
    for dy in range(-min(radius, y), min(radius, height - 1 - y) + 1):
        for dx in range(-min(radius, x), min(radius, width - 1 - x) + 1):
            total += totals[pixel + dy * width + dx]
    return total


@inlined
def _rest(total: float, gone: float) -> float:
    """What the oldest event leaves of a total: others weigh no less, else it is rounding."""
    rest = total - gone
    return rest if rest > 0.5 * gone else 0.0


@compiled
def _renew_unit(fresh: int, unit: int, is_anything_live: bool, table: Any, totals: Any) -> int:
    """Let the weights' unit start afresh; what counts is no older, so that no age is below 0."""
    factor = 1.0 / _weight(fresh - unit, table) if is_anything_live else 0.0
    for k in range(totals.size):
        totals[k] *= factor
    return fresh
