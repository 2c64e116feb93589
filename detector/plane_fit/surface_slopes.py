"""The surface of active events and its slopes: the kernel of the local plane fits.

The surface holds the time of the last edge at each pixel and polarity. A sharp edge makes a burst
of events in each pixel; the first of them gives the time of the edge.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flybench.events import Events
from flybench.kernels import compiled

F64 = npt.NDArray[np.float64]

NEVER_US = -(1 << 60)


class FitLimits(NamedTuple):
    """Limits of a plane fit; `PlaneFitConfig` explains each of them."""

    radius_px: int
    span_us: int
    burst_us: int
    least_neighbours: int
    tolerance_px: float


class SurfaceSlopes:
    """Fits a plane to the surface around the first event of each edge at each pixel."""

    def __init__(self, limits: FitLimits, *, width: int, height: int) -> None:
        """Start with a surface that no edge has passed.

        Args:
            limits: limits of a fit.
            width: sensor columns [px].
            height: sensor rows [px].
        """
        self._edge_us = np.full((2, height, width), NEVER_US, np.int64)
        self._event_us = np.full((2, height, width), NEVER_US, np.int64)
        self._limits = limits

    def fit(self, events: Events) -> F64:
        """Add the next events to the surface and return the slopes of the planes around them.

        Args:
            events: sorted by t; none earlier than those before.

        Returns:
            (fits, 2) float64: slopes (a, b) along x and y [s/px] of each plane that could be
            fitted, in the order of the events.
        """
        slopes = np.empty((events.size, 2))
        number = _fit_all(events, self._edge_us, self._event_us, self._limits, slopes)
        return slopes[:number]


@compiled
def _fit_all(events: Any, edge_us: Any, event_us: Any, limits: Any, slopes: Any) -> int:
    number = 0
    side = 2 * limits.radius_px + 1
    points, ranks = np.empty((side**2, 3)), np.empty(side**2, np.int64)
    swept = side * (limits.radius_px + 1)
    for n in range(events.size):
        event = events[n]
        p, y, x, t = int(event.p), int(event.y), int(event.x), int(event.t)
        is_burst = t - event_us[p, y, x] < limits.burst_us
        event_us[p, y, x] = t
        if is_burst:
            continue
        edge_us[p, y, x] = t
        count = _neighbours(edge_us[p], x, y, t, limits, points, ranks)
        if count < limits.least_neighbours:
            continue
        count = _youngest(points, ranks, count, swept)
        slope = _plane(points, count, limits)
        if slope[0] != 0.0 or slope[1] != 0.0:
            slopes[number, 0], slopes[number, 1] = slope
            number += 1
    return number


@compiled
def _neighbours(surface: Any, x: int, y: int, t: int, limits: Any, points: Any, ranks: Any) -> int:
    """Write dx, dy [px] and dt [s] of the recent edges around an event, and return their number.

    The event itself is among them. `ranks` grow with age. Of two neighbours of one age, the first
    found counts as the younger. Every neighbour is written and, if it is not recent, overwritten by
    the next, because noise makes a branch here unpredictable.
    """
    height, width = surface.shape
    radius, count = limits.radius_px, 0
    for row in range(max(y - radius, 0), min(y + radius + 1, height)):
        for column in range(max(x - radius, 0), min(x + radius + 1, width)):
            age = t - surface[row, column]
            points[count, 0], points[count, 1], points[count, 2] = column - x, row - y, age * -1e-6
            ranks[count] = age * len(ranks) + count
            count += age <= limits.span_us
    return count


@compiled
def _youngest(points: Any, ranks: Any, count: int, most: int) -> int:
    """Keep the youngest points, which this edge has swept, without those of edges ahead of it."""
    if count <= most:
        return count
    kept = 0
    for k in range(count):
        younger = 0
        for other in range(count):
            younger += ranks[other] < ranks[k]
        if younger < most:
            for axis in range(3):
                points[kept, axis] = points[k, axis]
            kept += 1
    return kept


@compiled
def _plane(points: Any, count: int, limits: Any) -> Any:
    """Fit t = a·x + b·y + c (Benosman et al., 2014, algorithm 1); return (a, b), or (0, 0) if none.

    After a least-squares fit, points that lie off the plane are removed and the fit is repeated, up
    to three fits in all.
    """
    a, b = 0.0, 0.0
    for _ in range(3):
        if count < limits.least_neighbours:
            return 0.0, 0.0
        a, b, c, is_plane = _least_squares(points, count)
        steepness = np.hypot(a, b)
        if not is_plane or steepness == 0.0:
            return 0.0, 0.0
        kept = 0
        for k in range(count):
            x, y, t = points[k, 0], points[k, 1], points[k, 2]
            if abs(a * x + b * y + c - t) <= limits.tolerance_px * steepness:
                points[kept, 0], points[kept, 1], points[kept, 2] = x, y, t
                kept += 1
        if kept == count:
            return a, b
        count = kept
    return (a, b) if count >= limits.least_neighbours else (0.0, 0.0)


@compiled
def _least_squares(points: Any, count: int) -> Any:
    """Return a, b, c of the plane through points, and True if the points span one."""
    mx = my = mt = xx = xy = yy = xt = yt = 0.0
    for k in range(count):
        x, y, t = points[k, 0], points[k, 1], points[k, 2]
        mx, my, mt = mx + x, my + y, mt + t
        xx, xy, yy = xx + x * x, xy + x * y, yy + y * y
        xt, yt = xt + x * t, yt + y * t
    mx, my, mt = mx / count, my / count, mt / count
    xx, xy, yy = xx - count * mx * mx, xy - count * mx * my, yy - count * my * my
    xt, yt = xt - count * mx * mt, yt - count * my * mt
    determinant = xx * yy - xy * xy
    if determinant < 1e-6 * count * count:
        return 0.0, 0.0, 0.0, False
    a = (xt * yy - yt * xy) / determinant
    b = (yt * xx - xt * xy) / determinant
    return a, b, mt - a * mx - b * my, True
