"""The results of an envelope: means by factor, and the range in which a method holds."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean
from typing import Any

import numpy as np
import numpy.typing as npt

from scenarios.envelope.grid import BASE, LEVELS, NOISE, SPEED

Row = dict[str, Any]
F64 = npt.NDArray[np.float64]
RIGHT, OPPOSITE, SIDEWAYS, NONE = (
    "accuracy_after_100ms",
    "opposite_after_100ms",
    "sideways_after_100ms",
    "none_after_100ms",
)
HOLDS = 0.95
"""A method holds where this share of its steps is right: what `wide` is asked for."""


def levels(rows: Sequence[Row], factor: str) -> list[Any]:
    """Levels of a factor: numbers in ascending order, names in that of measuring."""
    measured = list(dict.fromkeys(row[factor] for row in rows))
    return measured if any(isinstance(level, str) for level in measured) else sorted(measured)


def at_base(rows: Sequence[Row], free: Sequence[str]) -> list[Row]:
    """Rows in which every factor but the free ones has the base point's level.

    Where the base point's level was not measured, the factor's first takes its place.
    """
    kept = list(rows)
    for name in (SPEED, NOISE, *LEVELS):
        if name not in free:
            measured = levels(rows, name)
            base = getattr(BASE, name)
            level = base if base in measured else measured[0]
            kept = [row for row in kept if row[name] == level]
    return kept


def means(rows: Sequence[Row], x: str, y: str, value: str) -> F64:
    """Mean of a result over rows, by two factors: (levels of y, levels of x), NaN where none."""
    xs, ys = levels(rows, x), levels(rows, y)
    cells: dict[tuple[Any, Any], list[float]] = {}
    for row in rows:
        if row[value] is not None:
            cells.setdefault((row[y], row[x]), []).append(float(row[value]))
    return np.array([[fmean(cells.get((b, a), [np.nan])) for a in xs] for b in ys])


def worst(rows: Sequence[Row], x: str, y: str, over: str, value: str) -> F64:
    """As `means`, but of the level of factor `over` at which it is lowest."""
    maps = [means([r for r in rows if r[over] == o], x, y, value) for o in levels(rows, over)]
    return np.asarray(np.nanmin(maps, axis=0), np.float64)


def range_that_holds(rows: Sequence[Row]) -> tuple[float, float] | None:
    """Slowest and fastest of the longest run of speeds at which a method holds [px/s].

    Args:
        rows: of one method, at one point but for speed and seed; levels are averaged.

    Returns:
        None where it holds at no speed.
    """
    speeds = sorted(levels(rows, SPEED))
    holds = [_mean([r[RIGHT] for r in rows if r[SPEED] == v]) >= HOLDS for v in speeds]
    return _longest(speeds, holds)


def _longest(speeds: Sequence[float], holds: Sequence[bool]) -> tuple[float, float] | None:
    best: list[float] = []
    run: list[float] = []
    for speed, good in zip(speeds, holds, strict=True):
        run = [*run, speed] if good else []
        best = max(best, run, key=len)
    return (best[0], best[-1]) if best else None


def _mean(values: Sequence[float | None]) -> float:
    known = [value for value in values if value is not None]
    return fmean(known) if known else 0.0
