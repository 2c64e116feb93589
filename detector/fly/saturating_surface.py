"""Surfaces that saturate: they count an event itself, and further events of its pixel less.

The surface of the paper sums the earlier events of a pixel when an event comes (equation 2), so
that an edge with one event a pixel leaves it at 0. Here each event raises the surface S of its
pixel by a share of what is missing to 1, and S decays by e^(−t / τ) until the estimate is due. One
event counts, and a hundred count no more than 1. In fast texture, S still rises from the front of
an object to its back, because it takes several events to saturate.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from detector.cells import centred_cells, covering_cells
from detector.errors import StateError
from detector.fly.config import FlyConfig
from detector.fly.surface_history import SurfaceHistory
from flybench.events import Events
from flybench.kernels import compiled, inlined

F32 = npt.NDArray[np.float32]

NEVER_US = -(1 << 60)
"""Time of the latest event of a pixel that has had none [µs]."""
_NEIGHBOURS = np.array([0.25, 0.5, 0.25], np.float32)
"""Weights of a cell and its neighbours on each axis: half of the detail of two cells, which a pair
at the shortest distance cannot tell from motion in another direction, is averaged out (assumed)."""
_CEILING = 0.8
"""Share of the highest cell above which no cell is inhibited (assumed). Where a pattern fills the
field, mean and standard deviation are its own and not those of noise."""
_BURST_US = 4_000
"""Events of a pixel and polarity up to this time after another belong to one burst [µs]; see
`PlaneFitConfig` (assumed)."""
_NOTCH_US = 500
"""Half width of the notch around each multiple of 10 and 8.33 ms [µs] (assumed)."""
_TABLE_BITS = 5
"""Low bits of an age [µs] that its weight ignores: steps of 32 µs change it by 0.1 % (assumed)."""

_ARRAYS = ("latest", "levels", "onsets", "flickers", "surfaces", "has_surface")


class SaturatingSurfaces(SurfaceHistory):
    """Keeps the surface of each pixel and polarity at its latest event.

    The grid is centred on the sensor, so that mirrored streams give mirrored surfaces.

    Attributes:
        rows, columns: size of the grid.
        last_event_us: time of the last event [µs]; 0 before the first.
    """

    def __init__(self, config: FlyConfig, *, width: int, height: int) -> None:
        """Start empty, at time 0.

        Args:
            config: window, decay, cells and inhibition.
            width: sensor columns [px].
            height: sensor rows [px].
        """
        self._config = config
        side = config.cell_px
        self.rows, self.columns = covering_cells(height, side), covering_cells(width, side)
        super().__init__(config, grid=(self.rows, self.columns))
        self._down = centred_cells(height, side, self.rows)
        self._across = centred_cells(width, side, self.columns)
        ages_us = np.arange(0, config.window_us + (1 << _TABLE_BITS), 1 << _TABLE_BITS)
        self._table = np.exp(-ages_us / config.tau_us).astype(np.float32)
        self._levels = np.zeros((2, height, width), np.float32)
        self._onsets = np.full((2, height, width), NEVER_US, np.int64)
        self._flickers = np.zeros((2, height, width), np.bool_)
        self._latest = np.full((2, height, width), NEVER_US, np.int64)
        self.last_event_us = 0
        self.is_fresh = True

    @property
    def origin_px(self) -> tuple[int, int]:
        """Corner of the first cell, (x, y) on the sensor, not positive [px]."""
        side, (height, width) = self._config.cell_px, self._latest.shape[1:]
        return -((self.columns * side - width) // 2), -((self.rows * side - height) // 2)

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Return copies of everything that changes, as arrays by name."""
        state = {name: getattr(self, f"_{name}").copy() for name in _ARRAYS}
        return state | {
            "last_event_us": np.array(self.last_event_us),
            "is_fresh": np.array(self.is_fresh),
        }

    def restore(self, state: dict[str, npt.NDArray[Any]], *, now_us: int) -> None:
        """Continue from a `state` of surfaces with the same configuration and sensor.

        Args:
            state: candidate.
            now_us: time that the stream has reached [µs].

        Raises:
            StateError: an event is later than the last one, or than the stream.
        """
        last_us = int(state["last_event_us"])
        newest_us = max(int(state["latest"].max()), int(state["onsets"].max()))
        if not (newest_us <= last_us and 0 <= last_us <= now_us):
            raise StateError(
                f"The last event of the state is at {last_us} µs, and its latest pixel at "
                f"{newest_us} µs. Allowed are times in order, up to {now_us} µs. Pass everything "
                "that FlyDetector.state() returned, unchanged."
            )
        for name in _ARRAYS:
            setattr(self, f"_{name}", np.ascontiguousarray(state[name]).copy())
        self.last_event_us, self.is_fresh = last_us, bool(state["is_fresh"])

    def forget(self) -> None:
        """Return to the initial state."""
        self._latest[...] = NEVER_US
        self._levels[...] = 0.0
        self._onsets[...] = NEVER_US
        self._flickers[...] = False
        self._surfaces[...] = 0.0
        self._has_surface[...] = False
        self.last_event_us, self.is_fresh = 0, True

    def begin_hop(self, hop: int) -> None:
        """Do nothing: pixels keep no hops."""

    def accumulate(self, events: Events, start: int, *, until_us: int) -> int:
        """Add the events before `until_us` (in place of equation 2).

        Args:
            events: checked and sorted; none earlier than one that was added before.
            start: index of the first event to add.
            until_us: end of the hop, exclusive [µs].

        Returns:
            Index of the first event that was not added because it belongs to a later hop.
        """
        c = self._config
        parameters = c.window_us, c.event_gain, c.mains_notch
        pixels = self._latest, self._levels, self._onsets, self._flickers
        taken = _raise_levels(events, start, until_us, parameters, self._table, pixels)
        if taken > start:
            self.last_event_us, self.is_fresh = int(events["t"][taken - 1]), False
        return taken

    def average(self, *, hop: int) -> F32:
        """Return the surfaces at the end of a hop; `averaged` returns them again.

        Returns:
            (2, rows, columns) float32, in [0, 1]: OFF surface, ON surface.
        """
        end_us = (hop + 1) * self._config.hop_us
        if self.is_fresh or end_us - self.last_event_us > self._config.window_us:
            return self._keep(hop, None)
        means = np.zeros((2, self.rows, self.columns), np.float32)
        _sum_by_cell(
            self._latest,
            self._levels,
            end_us,
            self._config.window_us,
            self._table,
            self._down,
            self._across,
            means,
        )
        means /= self._config.cell_px**2
        self.activity = 2.0 * float(means.mean(dtype=np.float64))
        surfaces = [inhibited(smooth(mean), self._config.inhibition) for mean in means]
        return self._keep(hop, np.stack(surfaces))


def smooth(surface: F32) -> F32:
    """Return the mean of each cell and its neighbours; cells outside the grid count as 0."""
    smoothed = cv2.sepFilter2D(
        surface, -1, _NEIGHBOURS, _NEIGHBOURS, borderType=cv2.BORDER_CONSTANT
    )
    return np.asarray(smoothed, np.float32)


def inhibited(surface: F32, deviations: float) -> F32:
    """Subtract what noise may reach, and return the rest: lateral inhibition by the whole field.

    Noise that is alike everywhere raises the mean and the standard deviation of the field, and only
    what stands out of it is left. Half of the highest cell is never inhibited.

    Args:
        surface: (rows, columns) float32.
        deviations: level above the mean that counts as noise [standard deviations].
    """
    total, square, highest = _moments(surface)
    mean = total / surface.size
    level = mean + deviations * math.sqrt(max(square / surface.size - mean * mean, 0.0))
    level = min(level, _CEILING * highest)
    rest: F32 = np.maximum(surface - np.float32(level), np.float32(0.0))
    return rest


@compiled
def _moments(surface: Any) -> tuple[float, float, float]:
    """Return the sum, the sum of squares and the maximum of a surface."""
    total, square, highest = 0.0, 0.0, 0.0
    for row in surface:
        for value in row:
            total += value
            square += value * value
            highest = max(highest, value)
    return total, square, highest


@compiled
def _raise_levels(
    events: Any, start: int, until_us: int, parameters: Any, table: Any, pixels: Any
) -> int:
    """Let each event raise the surface of its pixel by a share of what is missing to 1.

    Returns the index of the first event that was not added because it comes at or after `until_us`.
    """
    window_us, gain, has_notch = parameters
    latest, levels, onsets, flickers = pixels
    keep, gain32 = np.float32(1.0 - gain), np.float32(gain)
    for n in range(start, events.size):
        event = events[n]
        if event.t >= until_us:
            return n
        p, y, x, t = np.int64(event.p), event.y, event.x, event.t
        if has_notch:
            interval = t - onsets[p, y, x]
            if interval > _BURST_US:
                onsets[p, y, x] = t
                flickers[p, y, x] = interval <= window_us and _is_flicker(interval)
            if flickers[p, y, x]:
                continue
        age = t - latest[p, y, x]
        level = np.float32(0.0)
        if age <= window_us:
            level = levels[p, y, x] * table[age >> _TABLE_BITS]
        latest[p, y, x] = t
        levels[p, y, x] = keep * level + gain32
    return int(events.size)


@inlined
def _is_flicker(interval_us: int) -> bool:
    """Return True if an interval is about a whole number of periods of the mains' flicker."""
    at_100_hz = (interval_us + _NOTCH_US) % 10_000 <= 2 * _NOTCH_US
    at_120_hz = (interval_us + _NOTCH_US) % 8_333 <= 2 * _NOTCH_US
    return at_100_hz or at_120_hz


@compiled
def _sum_by_cell(
    latest: Any,
    levels: Any,
    now_us: int,
    window_us: int,
    table: Any,
    down: Any,
    across: Any,
    sums: Any,
) -> None:
    """Add the surface of each pixel to that of its cell."""
    polarities, height, width = latest.shape
    active = np.empty(width, np.int32)  # a branch for each pixel would often be mispredicted
    for q in range(polarities):
        for y in range(height):
            row, times, here = sums[q, down[y]], latest[q, y], levels[q, y]
            number = 0
            for x in range(width):
                active[number] = x
                number += now_us - times[x] <= window_us
            for x in active[:number]:
                row[across[x]] += here[x] * table[(now_us - times[x]) >> _TABLE_BITS]
