"""The refractory period, from the edge of the histogram of intervals.

After an event, a pixel is held in reset, so no interval is shorter than the refractory period. If
the light changes fast enough, intervals come close to it, and their histogram has an edge there. On
slow light it has none: then the shortest intervals only give an upper limit.

Near the edge t_r, the density of intervals is taken as (t − t_r)^a, with a small share of outliers
anywhere. The edge is that of a reset if the shortest intervals crowd there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator.characterisation import Plot, Quantity, Section, Style
from emulator.characterisation.section import series
from scenarios.calibrate.fit import Fit, Parameter, unknown
from scenarios.calibrate.recording import PixelEvents

_SHORTEST = 1000
"""Number of the shortest intervals that are used (assumed)."""
_FEWEST = 200
_WIDEST = 0.5
"""Largest range of the shortest intervals, over the edge, that shows a reset (assumed)."""
_EXPONENTS = np.arange(0.0, 3.1, 0.5)
"""Exponents that are tried; higher ones would put the edge far below all intervals."""
_OUTLIERS = (1e-4, 1e-3, 1e-2)
_HALF_WIDTH = 1.92
"""Fall of the log likelihood at the ends of a 95 % interval (Wilks 1938)."""

F64 = npt.NDArray[np.float64]


class Edge(NamedTuple):
    """Edge of the histogram of intervals.

    Attributes:
        edge_us: shortest possible interval [µs].
        exponent: how gradually the density starts, 0 for a step.
        low_us: lower end of the 95 % interval of the edge [µs].
        high_us: upper end [µs].
        limit_us: longest interval that was used [µs].
    """

    edge_us: float
    exponent: float
    low_us: float
    high_us: float
    limit_us: float


def pixel_intervals_us(events: PixelEvents) -> F64:
    """Return all intervals from an event of a pixel to its next, sorted [µs]."""
    intervals = np.diff(events.t)[np.diff(events.pixel) == 0]
    return np.sort(intervals[intervals > 0]).astype(np.float64)


def fit_edge(intervals_us: F64) -> Edge | None:
    """Find the edge by maximum likelihood; None with too few intervals.

    Args:
        intervals_us: (n,) intervals, sorted [µs].
    """
    if intervals_us.size < _FEWEST:
        return None
    limit = float(intervals_us[min(_SHORTEST, intervals_us.size - 1)])
    short = intervals_us[intervals_us < limit]
    edges = np.linspace(0.0, 0.998 * limit, 500)
    best = [_best_exponent(short, edge, limit) for edge in edges]
    likelihoods = np.array([found[0] for found in best])
    k = int(likelihoods.argmax())
    near = edges[likelihoods > likelihoods[k] - _HALF_WIDTH]
    step = edges[1] - edges[0]
    return Edge(float(edges[k]), best[k][1], float(near[0] - step), float(near[-1] + step), limit)


def _best_exponent(short: F64, edge: float, limit: float) -> tuple[float, float]:
    """Return the highest log likelihood for an edge, and its exponent."""
    beyond = np.maximum(short - edge, 0.0) / (limit - edge)
    log = np.log(np.maximum(beyond, 1e-12))
    found = (-np.inf, 0.0)
    for exponent in _EXPONENTS:
        density = np.where(beyond > 0, np.exp(exponent * log), 0.0)
        density *= (exponent + 1.0) / (limit - edge)
        for share in _OUTLIERS:
            likelihood = float(np.log((1.0 - share) * density + share / limit).sum())
            found = max(found, (likelihood, float(exponent)))
    return found


def refractory_page(events: PixelEvents) -> Fit:
    """Return the refractory period, and the histogram with its edge."""
    intervals = pixel_intervals_us(events)
    edge = fit_edge(intervals)
    title = "Refractory period"
    method = (
        "No interval of a pixel is shorter than the time for which it is held in reset. The "
        f"density of the {_SHORTEST} shortest intervals is fitted by (t − t_r)^a. If they reach "
        f"farther than {1 + _WIDEST:g} t_r, the light was too slow to show the period, and t_r is "
        "only an upper limit of it. An interval also contains the time to the next threshold, so "
        "that the period may be somewhat shorter."
    )
    if edge is None:
        reason = f"a pixel's events follow each other fewer than {_FEWEST} times"
        missing = unknown("refractory_us", "µs", reason)
        return Fit("refractory", (missing,), Section(title, method, ()))
    rows = (
        Quantity("start of the intervals", "µs", edge.edge_us),
        Quantity("exponent a of the start", "", edge.exponent),
        Quantity("longest interval used", "µs", edge.limit_us),
    )
    if edge.limit_us <= (1.0 + _WIDEST) * edge.edge_us:
        evidence = f"from the {min(_SHORTEST, intervals.size):,} shortest intervals"
        interval = max(edge.low_us, 0.0), edge.high_us
        parameter = Parameter("refractory_us", "µs", round(edge.edge_us), interval, evidence)
    else:
        reason = f"the intervals have no edge; the period is at most about {edge.high_us:.0f} µs"
        parameter = unknown("refractory_us", "µs", reason)
    return Fit("refractory", (parameter,), Section(title, method, rows, [_plot(intervals, edge)]))


def _plot(intervals: F64, edge: Edge) -> Plot:
    bins = np.linspace(0.0, 3.0 * edge.limit_us, 121)
    counts, _ = np.histogram(intervals, bins)
    top = float(counts.max(initial=1))
    return Plot(
        "Intervals between events of a pixel",
        "interval [µs]",
        "number",
        [
            series("intervals", (bins[1:] + bins[:-1]) / 2, counts, Style.STEPS),
            series("start", [edge.edge_us] * 2, [0.0, top], Style.GUIDE),
        ],
    )
