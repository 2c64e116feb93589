"""Means with their confidence, over seeds and not over steps.

The steps of one run share events, sensor and scene, so their number says nothing of how certain a
mean is. Runs of different seeds share the light alone. An interval therefore takes one value a
seed: it holds for other sensors before the same scene, not for other scenes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean, stdev
from typing import Any

from scipy.stats import t

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
"""Columns of a row that lie in [0, 1], where an interval ends too."""
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
"""Columns of a row that are told by method and light."""


@dataclass(frozen=True)
class Interval:
    """A mean and where it lies with 95 % confidence.

    Attributes:
        mean: of the values.
        low: lower end.
        high: upper end; both are the mean where there is one value alone.
        number: how many values there are.
    """

    mean: float
    low: float
    high: float
    number: int


def mean_interval(values: Sequence[float | None], *, is_share: bool = False) -> Interval | None:
    """The mean of independent values, with Student's t.

    Args:
        values: one a seed; None where it has none.
        is_share: whether they lie in [0, 1], so that the interval is cut there.

    Returns:
        None where no value is known.
    """
    known = [value for value in values if value is not None]
    if not known:
        return None
    mean, number = fmean(known), len(known)
    if number == 1:
        return Interval(mean, mean, mean, 1)
    half = float(t.ppf((1 + CONFIDENCE) / 2, number - 1)) * stdev(known) / number**0.5
    low, high = mean - half, mean + half
    return (
        Interval(mean, max(low, 0.0), min(high, 1.0), number)
        if is_share
        else Interval(mean, low, high, number)
    )


def by_seed(rows: Sequence[Row], column: str) -> list[float | None]:
    """One value a seed: the mean over its rows, such as those of one method by day.

    Returns:
        In order of the seeds; None for a seed that has no value in any row.
    """
    found: dict[int, list[float]] = {}
    for row in rows:
        values = found.setdefault(row["seed"], [])
        if row[column] is not None:
            values.append(float(row[column]))
    return [fmean(values) if values else None for _, values in sorted(found.items())]


def interval_of(rows: Sequence[Row], column: str) -> Interval | None:
    """Mean of a column over rows, with its confidence over their seeds."""
    return mean_interval(by_seed(rows, column), is_share=column in SHARES)


def select(rows: Sequence[Row], **levels: Any) -> list[Row]:
    """Rows whose columns have these values."""
    return [row for row in rows if all(row[name] == value for name, value in levels.items())]


def each(rows: Sequence[Row], column: str) -> list[Any]:
    """The values of a column, each once, in order of their coming."""
    return list(dict.fromkeys(row[column] for row in rows))


def by_method_and_light(
    rows: Sequence[Row], measures: Sequence[str] = MEASURES
) -> dict[str, dict[str, Mapping[str, Interval | None]]]:
    """Every measure's interval, by method and then by light."""
    return {
        method: {
            light: {name: interval_of(own, name) for name in measures}
            for light in each(rows, "lighting")
            if (own := select(rows, method=method, lighting=light))
        }
        for method in each(rows, "method")
    }
