"""The unit of times that come without one, decided by their values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from statistics import median_low
from typing import TypeAlias

from formats import UNITS_US, unit_us

Unit: TypeAlias = str
"""Unit of time, as `formats.unit_us` takes it."""

USUAL_HZ = 100.0
"""Frame rate to which the chosen unit comes closest (assumed). Units differ by 1000, so the chosen
one gives 3 to 3000 frames per second if any does."""
YEARS_2000_TO_2100_US = 946_684_800_000_000, 4_102_444_800_000_000
"""Start of the years 2000 and 2100 in Unix time [µs]."""
PLAUSIBLE_HZ = 0.1, 100_000.0
MIN_STEP_IN_NAMES = 1000
"""Smallest step of whole numbers in file names that are times, in µs or ns (assumed). Smaller steps
are those of frame numbers, of which some may be missing."""


def rounded(value: float, digits: int) -> str:
    """Return a number with some significant digits, and without an exponent below a million."""
    return f"{float(f'{value:.{digits}g}'):g}"


def in_us(values: Sequence[Fraction], unit: Unit) -> list[Fraction]:
    """Return times in µs.

    Raises:
        FormatError: there is no such unit.
    """
    factor = unit_us(unit)
    return [value * factor for value in values]


def guess_unit(values: Sequence[Fraction], *, in_names: bool) -> tuple[Unit, str] | None:
    """Return the unit of times and the reason, or None if the values are frame numbers.

    Whole numbers are not seconds. If one unit makes them Unix times of this century, it is chosen;
    otherwise the one whose frame rate is closest to a usual one.

    Args:
        values: at least two times, in any order.
        in_names: True for numbers in file names, which are more often frame numbers.
    """
    steps = [after - before for before, after in pairwise(sorted(values))]
    step, whole = median_low(steps), all(value.denominator == 1 for value in values)
    if step <= 0 or (whole and step == 1):
        return None
    if whole and in_names and min(steps) < MIN_STEP_IN_NAMES:
        return None
    units: tuple[Unit, ...] = ("ms", "us", "ns") if whole else ("s", "ms", "us")
    rates = {unit: float(1_000_000 / (step * UNITS_US[unit])) for unit in units}
    first, last = YEARS_2000_TO_2100_US
    low, high = PLAUSIBLE_HZ
    for unit, hz in rates.items():
        if first <= values[0] * UNITS_US[unit] < last and low <= hz <= high:
            return unit, "Unix times of this century; --time-unit sets another"
    unit = min(units, key=lambda unit: abs(math.log(rates[unit] / USUAL_HZ)))
    numbers = "whole numbers" if whole else "fractions"
    return unit, f"{numbers} that give {rounded(rates[unit], 3)} Hz; --time-unit sets another"
