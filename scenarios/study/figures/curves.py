"""What the seeds of one method said over time, and their mean."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from detector.estimate import MotionEstimate
from scenarios.study.results import MethodRun

F64 = npt.NDArray[np.float64]
Value = Callable[[MotionEstimate], float]


@dataclass(frozen=True, eq=False)
class Curve:
    """One figure over time.

    Attributes:
        t_us: (n,) float64, rising [µs].
        values: (n,) float64; not a number where there is nothing to show.
    """

    t_us: F64
    values: F64


def curve(run: MethodRun, value: Value) -> Curve:
    """A figure of each of a run's estimates."""
    times = np.array([e.t_us for e in run.estimates], np.float64)
    return Curve(times, np.array([value(e) for e in run.estimates], np.float64))


def mean_curve(curves: Sequence[Curve]) -> Curve:
    """Mean over the seeds at each time of any seed, within the span that all of them cover.

    Where seeds have times of their own, as those of frames are in the dark, each goes straight
    from one of its values to the next. What is not a number is left out of the mean.

    Args:
        curves: one a seed.

    Returns:
        The mean; empty where a seed said nothing.
    """
    if not curves or any(one.t_us.size == 0 for one in curves):
        return Curve(np.empty(0), np.empty(0))
    first, last = max(c.t_us[0] for c in curves), min(c.t_us[-1] for c in curves)
    times = np.unique(np.concatenate([c.t_us for c in curves]))
    times = times[(times >= first) & (times <= last)]
    table = np.stack([_at(times, c) for c in curves])
    known = np.isfinite(table)
    number = known.sum(axis=0)
    total = np.where(known, table, 0.0).sum(axis=0)
    return Curve(times, np.where(number > 0, total / np.maximum(number, 1), np.nan))


def _at(times: F64, one: Curve) -> F64:
    if np.array_equal(times, one.t_us):
        return one.values
    return np.interp(times, one.t_us, one.values)
