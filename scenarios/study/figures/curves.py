"""Curves of a method's estimates over time, and their mean over seeds."""

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
    """One quantity over time.

    Attributes:
        t_us: (n,) float64, rising times [µs].
        values: (n,) float64; NaN leaves a gap.
    """

    t_us: F64
    values: F64


def curve(run: MethodRun, value: Value) -> Curve:
    """Return a quantity of each estimate of a run."""
    times = np.array([e.t_us for e in run.estimates], np.float64)
    return Curve(times, np.array([value(e) for e in run.estimates], np.float64))


def mean_curve(curves: Sequence[Curve]) -> Curve:
    """Return the mean over the seeds at every time of any seed, in the time that all cover.

    Where the times of the seeds differ, as those of APS frames do in the dark, each curve is
    interpolated linearly. NaN is left out of the mean.

    Args:
        curves: one for each seed.

    Returns:
        The mean; empty if a seed has no estimates.
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
