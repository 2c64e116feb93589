"""Time surfaces of single events and the histogram of each cell (equations 2 to 4).

For every pixel and polarity, the sum of equation 2 is kept as a running total W of weights
e^((t_j − origin) / τ). The surface of an event is W over the weight of an event now. This costs one
addition when an event comes and one subtraction when it leaves the window, however many events lie
between.

The event that leaves the window is the oldest and has the smallest weight, so the subtraction does
not lose significant digits. What remains of a pixel's total is either an event of at least that
weight, or rounding error, which is set to zero. The operations on a pixel follow from the event
times alone, so the cuts between chunks change no bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined

Longs = npt.NDArray[np.int64]
Ints = npt.NDArray[np.int32]

NOW, ORIGIN, OLDEST, PENDING, NEWEST = range(5)
"""Entries of the clock.

The first two are the time reached and the origin of the weights [µs]. The other three count events
from the start: the oldest in the window, the first that is not in the totals yet because it is of
the present microsecond (events of one microsecond must not affect one another), and the next.
"""

COUNT_BITS = 32
"""Bit of an entry of `merged` from which on it holds a number of events.

The lower bits are their pixel. Equal events are merged only where memory would have to grow; see
`merge_equal`. An entry −1 − k of `pixels` stands for entry k of `merged`.
"""
PIXEL_MASK = (1 << COUNT_BITS) - 1

_ORIGIN_AGE_TAUS = 300
"""Age in τ at which the origin of the weights is renewed: e^300 is far from overflow."""

_TABLE_BITS = 12
_TABLE_SIZE = 1 << _TABLE_BITS
_ORIGIN_AGE_US = 1 << 2 * _TABLE_BITS
"""Greatest age of the origin [µs]: weights come from a table of the low bits of the age and one of
its high bits."""


def origin_age_us(tau_us: int) -> int:
    """Return the age at which the origin of the weights is renewed [µs]."""
    return min(_ORIGIN_AGE_TAUS * tau_us, _ORIGIN_AGE_US)


def weight_table(tau_us: int) -> npt.NDArray[np.float64]:
    """Return e^(t / τ) for ages t, as factors for the low bits followed by those for the high bits.

    Both are in one array because every array argument adds to the cost of a kernel call.
    """
    low = np.exp(np.arange(_TABLE_SIZE) / tau_us)
    high = np.exp(np.arange(0, origin_age_us(tau_us) + 1, _TABLE_SIZE) / tau_us)
    return np.concatenate([low, high])


def merge_equal(times: Longs, pixels: Ints, merged: Longs) -> tuple[Longs, Ints, Longs]:
    """Merge the entries of equal time and pixel into one, which counts them.

    Events of one microsecond do not affect one another, so their order does not matter.

    Args:
        times: times of the entries, sorted [µs].
        pixels: pixels of the entries, or −1 − k for entry k of `merged`.
        merged: pixels and numbers of events of merged entries; see `COUNT_BITS`.

    Returns:
        The same without repetition, sorted by time and pixel.
    """
    entries = pixels + np.int64(1 << COUNT_BITS)
    entries[pixels < 0] = merged[-1 - pixels[pixels < 0]]
    order = np.lexsort((entries & PIXEL_MASK, times))
    times, entries = times[order], entries[order]
    places = entries & PIXEL_MASK
    starts = np.flatnonzero(np.diff(times, prepend=-1) | np.diff(places, prepend=-1))
    counts = np.add.reduceat(entries >> COUNT_BITS, starts)
    times, pixels = times[starts], places[starts].astype(np.int32)
    several = np.flatnonzero(counts > 1)
    merged = pixels[several] | counts[several] << COUNT_BITS
    pixels[several] = -1 - np.arange(several.size)
    return times, pixels, merged


@compiled
def add_to_histogram(
    events: Any, start: int, until_us: int, parameters: Any, memory: Any, slot: int
) -> int:
    """Add the events before `until_us` to the histogram of each cell (paper, equation 4).

    `parameters` and `memory` are plain tuples: named ones add 1.4 µs to every call, a quarter of
    what a chunk of 100 events takes. The cell of a pixel is the sum of its column's and its row's
    entries in `cells`; those of the rows follow those of the columns.

    Returns the index of the first event that was not added; if the buffer is full, −1 minus that
    index.
    """
    window_us, renewal_us, radius, counts_itself, width, table, cells = parameters
    totals, times, pixels, merged, clock, tallies = memory
    height, grid_size = cells.size - width, tallies.shape[2] * tallies.shape[3]
    tally, wrap = tallies[slot].reshape(-1), times.size - 1
    now, origin, oldest, pending, newest = clock
    weight = _weight(now - origin, table)
    taken = events.size
    for n in range(start, events.size):
        event = events[n]
        if event.t >= until_us:
            taken = n
            break
        if event.t != now:
            now = event.t
            _add_pending(totals, pixels, merged, pending, newest, weight)
            pending, start_us = newest, now - window_us
            oldest = _drop_expired(
                totals, times, pixels, merged, oldest, newest, start_us, origin, table
            )
            if now - origin >= renewal_us:
                origin = _renew_origin(start_us, origin, oldest < newest, table, totals)
            weight = _weight(now - origin, table)
        if newest - oldest > wrap:
            taken = -1 - n
            break
        q = np.int64(event.p)
        pixel = (q * height + event.y) * width + event.x
        k = 2 * (q * grid_size + cells[width + event.y] + cells[event.x])
        total = _time_surface(totals, pixel, event.x, event.y, radius, width, height)
        tally[k] += total / weight + counts_itself
        tally[k + 1] += 1.0
        times[newest & wrap], pixels[newest & wrap] = now, pixel
        newest += 1
    clock[:] = now, origin, oldest, pending, newest
    return int(taken)


@inlined
def _weight(age_us: int, table: Any) -> float:
    """Return the weight e^(age / τ) of an event this long after the origin."""
    return float(table[age_us & (_TABLE_SIZE - 1)] * table[_TABLE_SIZE + (age_us >> _TABLE_BITS)])


@inlined
def _time_surface(
    totals: Any, pixel: int, x: int, y: int, radius: int, width: int, height: int
) -> float:
    """Return the time surface of an event (paper, equation 2), summed over z (equation 3).

    It is relative to the origin of the weights, so that the caller divides it by the weight of an
    event now.
    """
    if radius == 0:
        return float(totals[pixel])
    total = 0.0
    for dy in range(-min(radius, y), min(radius, height - 1 - y) + 1):
        for dx in range(-min(radius, x), min(radius, width - 1 - x) + 1):
            total += totals[pixel + dy * width + dx]
    return total


@inlined
def _add_pending(
    totals: Any, pixels: Any, merged: Any, pending: int, newest: int, weight: float
) -> None:
    """Add the events of the past microsecond to the totals of their pixels."""
    wrap = pixels.size - 1
    for k in range(pending, newest):
        pixel = pixels[k & wrap]
        if pixel >= 0:
            totals[pixel] += weight
        else:
            _add_merged(totals, merged[-1 - pixel], weight)


@compiled
def _add_merged(totals: Any, entry: int, weight: float) -> None:
    """Add the events of an entry of `merged`; one by one, so that merging changes no bit."""
    for _ in range(entry >> COUNT_BITS):
        totals[entry & PIXEL_MASK] += weight


@compiled
def _drop_merged(totals: Any, entry: int, weight: float) -> None:
    """Subtract the events of an entry of `merged`, one by one."""
    for _ in range(entry >> COUNT_BITS):
        rest = totals[entry & PIXEL_MASK] - weight
        totals[entry & PIXEL_MASK] = rest if rest > 0.5 * weight else 0.0


@inlined
def _drop_expired(
    totals: Any,
    times: Any,
    pixels: Any,
    merged: Any,
    oldest: int,
    newest: int,
    start_us: int,
    origin: int,
    table: Any,
) -> int:
    """Subtract events before the start of the window; return the number of the oldest in it."""
    wrap = times.size - 1
    while oldest < newest and times[oldest & wrap] < start_us:
        weight = _weight(times[oldest & wrap] - origin, table)
        pixel = pixels[oldest & wrap]
        if pixel >= 0:
            rest = totals[pixel] - weight
            # Another event would weigh at least as much: less than half of it is rounding error.
            totals[pixel] = rest if rest > 0.5 * weight else 0.0
        else:
            _drop_merged(totals, merged[-1 - pixel], weight)
        oldest += 1
    return oldest


@compiled
def _renew_origin(new: int, origin: int, has_events: bool, table: Any, totals: Any) -> int:
    """Move the origin of the weights to the start of the window, so that no age is negative."""
    factor = 1.0 / _weight(new - origin, table) if has_events else 0.0
    for k in range(totals.size):
        totals[k] *= factor
    return new
