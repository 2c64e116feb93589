"""The unit of a file's timestamps: what the file or the user states, or what their values show.

Without a statement, the values decide as follows. Times with decimals are seconds; whole numbers
are not, even if they are stored as floating-point numbers. A unit with which the event rate is
outside `RATES_HZ` is not accepted if another one fits. What remains uncertain is a warning.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from formats.columns import Array
from formats.errors import FormatError

RATES_HZ = (10.0, 1e8)
"""Plausible event rates [events/s] (assumed: from a dark still scene to the fastest readout)."""

UNITS_US = {"s": Fraction(10**6), "ms": Fraction(1000), "us": Fraction(1), "ns": Fraction(1, 1000)}
"""Units of time by name [µs]."""
_ENOUGH = 100
"""Fewest events whose rate says anything (assumed)."""
_SLOW_HZ = 1e4
"""Event rate below which one frame per ms of a simulator is implausible [events/s] (assumed)."""
_INTERVALS = 10
"""Fewest different intervals between the events of a camera (assumed)."""
_FRAME_TIMES = 10
"""Fewest times in a row from 0 or 1 on that look like frame numbers (assumed)."""
_SAMPLE = 1 << 16
"""Most timestamps that are examined."""
_TIME_MAX_US = 2**62
_NS_FROM = 10**17
"""Times of this size and more are a wall clock in ns; in µs they would be 3000 years."""

_UNIT = re.compile(r"(\d+(?:\.\d+)?)?(?:/(\d+(?:\.\d+)?))?\s*(s|ms|us|µs|ns)")


@dataclass(frozen=True)
class TimeUnit:
    """Unit of the timestamps of a file.

    Attributes:
        name: a unit as `unit_us` takes it.
        reason: why it was taken.
        warning: what speaks against it; empty if nothing does.
    """

    name: str
    reason: str
    warning: str = ""

    def __str__(self) -> str:
        """Return the unit and the reason, to be displayed."""
        return f"{self.name.replace('us', 'µs')}, {self.reason}"


def unit_us(name: str) -> Fraction:
    """Return a unit of time in µs.

    Args:
        name: "s", "ms", "us" or "ns"; a number may come before it, such as "33.3ms" or "1/30s".

    Raises:
        FormatError: it is none of these.
    """
    found = _UNIT.fullmatch(name.strip())
    if found is not None:
        count, parts = Fraction(found[1] or 1), Fraction(found[2] or 1)
        if count > 0 and parts > 0:
            return count / parts * UNITS_US[found[3].replace("µ", "u")]
    raise FormatError(
        f"The time unit is {name!r}. Allowed is one of s, ms, us, ns, with a number before it for "
        "times that count steps, such as 33.3ms or 1/30s. Correct --time-unit."
    )


def to_microseconds(time: Array, unit: str, *, path: Path) -> Array:
    """Return timestamps as int64 [µs].

    Args:
        time: timestamps as stored in the file.
        unit: their unit, as `unit_us` takes it.
        path: path of the file, for error messages.

    Raises:
        FormatError: a timestamp is not finite or too large.
    """
    factor = unit_us(unit)
    if not time.size:
        return time.astype(np.int64)
    whole = np.issubdtype(time.dtype, np.integer)
    largest = float(max(abs(time.max()), abs(time.min()))) * float(factor)
    if not largest < _TIME_MAX_US:  # also for NaN
        raise FormatError(
            f"{path} has a timestamp that is not a finite number of {unit} below 2^62 µs. Repair "
            "or remove that event."
        )
    if whole and factor.denominator == 1:
        microseconds = time.astype(np.int64, copy=False)
        return microseconds if factor == 1 else microseconds * int(factor)
    if whole and factor.numerator == 1:
        return time.astype(np.int64) // factor.denominator
    return np.rint(time * float(factor)).astype(np.int64)


def choose_unit(
    times: Array, *, option: str | None, stated: str | None, source: str, path: Path
) -> TimeUnit:
    """Return the unit of a file's timestamps.

    Args:
        times: the first timestamps, as stored; thousands if possible.
        option: unit that the user states; None: not stated.
        stated: unit that the file or its format states; None: not stated.
        source: what states it.
        path: path of the file, for messages.

    Raises:
        FormatError: no unit fits the values, or several fit equally well.
    """
    if option is not None:
        return TimeUnit(option, "from --time-unit")
    sample = _Sample(times[:_SAMPLE])
    if stated is not None:
        return TimeUnit(stated, source, _rate_warning(sample, stated, path))
    return _unit_of_whole(sample, path) if sample.whole else _unit_of_decimals(sample, path)


class _Sample:
    """What the first timestamps of a file show.

    Attributes:
        count: number of timestamps.
        whole: True if all are whole numbers.
        first: the first.
        ticks: all, from the first on.
    """

    def __init__(self, times: Array) -> None:
        if np.issubdtype(times.dtype, np.floating):
            times = times[np.isfinite(times)]
        self.count = times.size
        self.whole = bool((times == np.rint(times)).all())
        self.first = times[0].item() if times.size else 0
        self.ticks = times.astype(np.float64) - self.first

    @property
    def span(self) -> float:
        """Difference of the largest and the smallest timestamp."""
        return float(np.ptp(self.ticks)) if self.count else 0.0

    def rate_hz(self, unit: str) -> float | None:
        """Return the event rate if the timestamps have this unit; None if they cannot tell."""
        if self.count < _ENOUGH or not self.span:
            return None
        return self.count / (self.span * float(unit_us(unit))) * 1e6

    def fits(self, unit: str) -> bool:
        """Return True if the event rate is plausible with this unit, or cannot be told."""
        rate_hz = self.rate_hz(unit)
        return rate_hz is None or RATES_HZ[0] <= rate_hz <= RATES_HZ[1]

    def has_steps_of(self, step: float) -> bool:
        """Return True if timestamps lie on a grid of exactly this step, at various intervals."""
        ticks = np.rint(self.ticks / step)
        if self.count < _ENOUGH or not np.allclose(self.ticks / step, ticks, rtol=0, atol=1e-3):
            return False
        intervals = np.unique(np.abs(np.diff(ticks)).astype(np.int64))
        return intervals.size >= _INTERVALS and int(np.gcd.reduce(intervals)) == 1

    def are_like_frame_numbers(self) -> bool:
        """Return True if the timestamps are all numbers from 0 or 1 on, with many events each."""
        times = np.unique(self.ticks)
        in_a_row = times.size == self.span + 1 >= _FRAME_TIMES
        return self.first in (0, 1) and in_a_row and self.count >= 2 * times.size


def _unit_of_whole(sample: _Sample, path: Path) -> TimeUnit:
    """Return the unit of timestamps that are whole numbers: µs or ns."""
    if sample.first >= _NS_FROM:
        return TimeUnit("ns", "because of the size of the times")
    rate_hz = sample.rate_hz("us")
    whole = "because the times are whole numbers"
    if rate_hz is None:
        return TimeUnit("us", whole)
    if rate_hz > RATES_HZ[1]:
        raise FormatError(
            f"{path} has {sample.count:,} events at times from {sample.first:.0f} to "
            f"{sample.first + sample.span:.0f}, which are ms or frame numbers. In µs there would "
            "be more than 10^8 events per second. State the unit with --time-unit, such as ms, or "
            "the time of one frame, such as 33.3ms or 1/30s."
        )
    if rate_hz < RATES_HZ[0] and sample.fits("ns"):
        return TimeUnit("ns", f"because in µs there would be {rate_hz:.2g} events/s")
    if sample.has_steps_of(1000) and sample.fits("ns"):
        if rate_hz < _SLOW_HZ:
            return TimeUnit("ns", "because the times are multiples of 1000")
        return TimeUnit("us", whole, _doubt(path, "us", "are multiples of 1000", "ns"))
    if sample.are_like_frame_numbers():
        doubt = _doubt(path, "us", "count up from 0 or 1", "the time of a frame, such as 1/30s")
        return TimeUnit("us", whole, doubt)
    if rate_hz < _SLOW_HZ and sample.fits("us") and sample.fits("ns"):
        return TimeUnit("us", whole, _slow_warning(sample, rate_hz, path))
    return TimeUnit("us", whole, _rate_warning(sample, "us", path))


def _unit_of_decimals(sample: _Sample, path: Path) -> TimeUnit:
    """Return the unit of timestamps with decimals: s, ms or µs."""
    rate_hz = sample.rate_hz("s")
    decimals = "because the times have decimals"
    if rate_hz is None:
        return TimeUnit("s", decimals)
    if rate_hz < RATES_HZ[0]:
        fitting = [unit for unit in ("ms", "us") if sample.fits(unit)]
        if len(fitting) > 1:
            raise FormatError(
                f"{path} has times with decimals, but in seconds there would be {rate_hz:.2g} "
                "events per second. They may be ms or µs. State the unit with --time-unit."
            )
        if fitting:
            reason = f"because in s there would be {rate_hz:.2g} events/s"
            return TimeUnit(fitting[0], reason)
    if sample.has_steps_of(0.001) and sample.fits("ms"):
        if rate_hz < _SLOW_HZ:
            return TimeUnit("ms", "because the times have three decimals")
        return TimeUnit("s", decimals, _doubt(path, "s", "have three decimals", "ms"))
    return TimeUnit("s", decimals, _rate_warning(sample, "s", path))


def _doubt(path: Path, unit: str, finding: str, other: str) -> str:
    return (
        f"{path}: the times are read in {unit.replace('us', 'µs')}, but all {finding}. If that is "
        f"wrong, state the unit with --time-unit: {other}."
    )


def _slow_warning(sample: _Sample, rate_hz: float, path: Path) -> str:
    return (
        f"{path}: the times are read in µs, which gives {rate_hz:,.0f} events per second. In "
        f"ns there would be {sample.rate_hz('ns'):,.0f}. If the times are in ns, state it with "
        "--time-unit ns."
    )


def _rate_warning(sample: _Sample, unit: str, path: Path) -> str:
    """Return a warning if the event rate is implausible with this unit, else an empty text."""
    if sample.fits(unit):
        return ""
    return (
        f"{path}: the times are read in {unit.replace('us', 'µs')}. This gives "
        f"{sample.rate_hz(unit):.2g} events per second. Plausible are 10 to 10^8. If the unit is "
        "wrong, state it with --time-unit."
    )
