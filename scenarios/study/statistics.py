"""Means with confidence intervals, over seeds and not over steps.

The steps of one run share events, sensor and scene, so their number does not show how certain a
mean is. Runs of different seeds share only the rendered luminance. An interval therefore uses one
value for each seed. It is valid for other sensors that see the same scene, not for other scenes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Any

import numpy as np
from scipy.special import stdtrit

from scenarios.study.rows import Row

CONFIDENCE = 0.95
SHARES = frozenset(
    {
        "accuracy",
        "accuracy_after_100ms",
        "opposite_after_100ms",
        "sideways_after_100ms",
        "none_after_100ms",
        "roi_iou",
    }
)
"""Columns with values in [0, 1], to which their intervals are clipped."""
MEASURES = (
    "accuracy",
    "accuracy_after_100ms",
    "opposite_after_100ms",
    "sideways_after_100ms",
    "none_after_100ms",
    "latency_ms",
    "response_mean",
    "response_variation",
    "velocity_error_px_s",
    "velocity_bias_px_s",
    "roi_iou",
    "centroid_error_px",
    "grms",
    "ms_per_estimate",
    "ns_per_event",
)
"""Columns that the summary gives by method and lighting."""


@dataclass(frozen=True)
class Interval:
    """A mean and its 95 % confidence interval.

    Attributes:
        mean: mean of the values.
        low: lower end of the interval; the mean if there is only one value.
        high: upper end of the interval; the mean if there is only one value.
        number: number of values.
    """

    mean: float
    low: float
    high: float
    number: int


def mean_interval(values: Sequence[float | None], *, is_share: bool = False) -> Interval | None:
    """Return the mean of independent values and its interval by Student's t distribution.

    Args:
        values: one value for each seed; None for a seed without a value.
        is_share: True if the values are in [0, 1], so that the interval is clipped to that range.

    Returns:
        The interval; None if there is no value.
    """
    known = [value for value in values if value is not None]
    if not known:
        return None
    mean, number = fmean(known), len(known)
    if number == 1:
        return Interval(mean, mean, mean, 1)
    of_the_mean = np.std(known, ddof=1) / math.sqrt(number)
    half = float(stdtrit(number - 1, (1 + CONFIDENCE) / 2) * of_the_mean)
    low, high = mean - half, mean + half
    if is_share:
        low, high = max(low, 0.0), min(high, 1.0)
    return Interval(mean, low, high, number)


def seed_means(rows: Sequence[Row], column: str) -> list[float | None]:
    """Return one value for each seed: the mean of a column over the rows of that seed.

    Returns:
        Means in order of the seeds; None for a seed without a value in any row.
    """
    found: dict[int, list[float]] = {}
    for row in rows:
        values = found.setdefault(row["seed"], [])
        if row[column] is not None:
            values.append(float(row[column]))
    return [fmean(values) if values else None for _, values in sorted(found.items())]


def interval_of(rows: Sequence[Row], column: str) -> Interval | None:
    """Return the mean of a column over rows, with its confidence interval over the seeds."""
    return mean_interval(seed_means(rows, column), is_share=column in SHARES)


def select(rows: Sequence[Row], **levels: Any) -> list[Row]:
    """Return the rows whose columns have these values."""
    return [row for row in rows if all(row[name] == value for name, value in levels.items())]


def distinct(rows: Sequence[Row], column: str) -> list[Any]:
    """Return the distinct values of a column, in order of first appearance."""
    return list(dict.fromkeys(row[column] for row in rows))


def by_method_and_lighting(
    rows: Sequence[Row], measures: Sequence[str] = MEASURES
) -> dict[str, dict[str, Mapping[str, Interval | None]]]:
    """Return the interval of every measure, by method and then by lighting."""
    return {
        method: {
            lighting: {name: interval_of(own, name) for name in measures}
            for lighting in distinct(rows, "lighting")
            if (own := select(rows, method=method, lighting=lighting))
        }
        for method in distinct(rows, "method")
    }
