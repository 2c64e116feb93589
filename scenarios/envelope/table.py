"""Statistics of an envelope: means by factor, and the operating range of a method."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean
from typing import Any

import numpy as np
import numpy.typing as npt

from scenarios.envelope.grid import BASE, LEVELS, NOISE, SPEED

Row = dict[str, Any]
F64 = npt.NDArray[np.float64]
CORRECT, OPPOSITE, SIDEWAYS, NONE = (
    "accuracy_after_100ms",
    "opposite_after_100ms",
    "sideways_after_100ms",
    "none_after_100ms",
)
MIN_CORRECT = 0.95
"""Lowest share of correct steps within the operating range; `wide` was designed for it."""


def levels(rows: Sequence[Row], factor: str) -> list[Any]:
    """Return the levels of a factor: numbers in ascending order, names in the measured order."""
    measured = list(dict.fromkeys(row[factor] for row in rows))
    return measured if any(isinstance(level, str) for level in measured) else sorted(measured)


def at_base_point(rows: Sequence[Row], free: Sequence[str]) -> list[Row]:
    """Return the rows in which all factors except the free ones have the base point's level.

    If the base point's level of a factor was not measured, its first level is used instead.
    """
    kept = list(rows)
    for name in (SPEED, NOISE, *LEVELS):
        if name not in free:
            measured = levels(rows, name)
            base = getattr(BASE, name)
            level = base if base in measured else measured[0]
            kept = [row for row in kept if row[name] == level]
    return kept


def mean_by_cell(rows: Sequence[Row], x: str, y: str, value: str) -> F64:
    """Return the mean of a result by two factors: (levels of y, levels of x); NaN if no row."""
    xs, ys = levels(rows, x), levels(rows, y)
    cells: dict[tuple[Any, Any], list[float]] = {}
    for row in rows:
        if row[value] is not None:
            cells.setdefault((row[y], row[x]), []).append(float(row[value]))
    return np.array([[fmean(cells.get((b, a), [np.nan])) for a in xs] for b in ys])


def worst_level(rows: Sequence[Row], x: str, y: str, over: str, value: str) -> F64:
    """Return the lowest `mean_by_cell` over all levels of the factor `over`."""
    maps = [
        mean_by_cell([r for r in rows if r[over] == o], x, y, value) for o in levels(rows, over)
    ]
    return np.asarray(np.nanmin(maps, axis=0), np.float64)


def operating_range(rows: Sequence[Row]) -> tuple[float, float] | None:
    """Return the longest range of measured speeds at which enough steps are correct.

    Args:
        rows: rows of one method that differ in speed, seed and crossed factors; results at one
            speed are averaged.

    Returns:
        Lowest and highest speed [px/s]; None if there is no such speed.
    """
    speeds = sorted(levels(rows, SPEED))
    good = [_mean([r[CORRECT] for r in rows if r[SPEED] == v]) >= MIN_CORRECT for v in speeds]
    return _longest_run(speeds, good)


def _longest_run(speeds: Sequence[float], good: Sequence[bool]) -> tuple[float, float] | None:
    best: list[float] = []
    run: list[float] = []
    for speed, is_good in zip(speeds, good, strict=True):
        run = [*run, speed] if is_good else []
        best = max(best, run, key=len)
    return (best[0], best[-1]) if best else None


def _mean(values: Sequence[float | None]) -> float:
    known = [value for value in values if value is not None]
    return fmean(known) if known else 0.0
