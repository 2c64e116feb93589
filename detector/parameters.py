"""The check on the numbers of a detector's configuration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from numbers import Integral, Real
from typing import Any

from detector.errors import DetectorConfigError


def check_numbers(config: Any, ranges: Mapping[str, tuple[float, float]]) -> None:
    """Refuse numbers out of their range, and bring NumPy's to Python's.

    Args:
        config: a frozen dataclass that is being made; a field whose default is an int takes whole
            numbers alone.
        ranges: lowest and highest allowed value of each field to check, both included.

    Raises:
        DetectorConfigError: a value of another type, or outside its range.
    """
    defaults = {field.name: field.default for field in fields(config)}
    for name, allowed in ranges.items():
        default = defaults[name]
        number = checked_number(
            name, getattr(config, name), allowed, whole=isinstance(default, int), default=default
        )
        object.__setattr__(config, name, number)


def checked_number(
    name: str, value: Any, allowed: tuple[float, float], *, whole: bool, default: object
) -> int | float:
    """The value as Python's int, where it has to be whole, or else as its float.

    Args:
        name: of the parameter, for the refusal.
        value: candidate.
        allowed: lowest and highest, both included.
        whole: whether whole numbers alone will do.
        default: of the parameter, for the refusal.

    Raises:
        DetectorConfigError: a value of another type, or outside its range.
    """
    low, high = allowed
    kind: type = Integral if whole else Real
    is_number = isinstance(value, kind) and not isinstance(value, bool)
    if not (is_number and low <= value <= high):
        raise DetectorConfigError(
            f"{name} is {value!r}; allowed is {'a whole number from ' if whole else ''}{low:g} to "
            f"{high:g}; the default is {default}"
        )
    return int(value) if whole else float(value)


def check_whole_hops(hop_us: int, **times_us: int) -> None:
    """Refuse times that hops do not fill.

    Args:
        hop_us: length of a hop [µs].
        times_us: what has to be a whole multiple of it, by name [µs].

    Raises:
        DetectorConfigError: one of them is not.
    """
    for name, value in times_us.items():
        if value % hop_us:
            raise DetectorConfigError(
                f"{name} is {value} µs, no multiple of hop_us = {hop_us} µs; allowed are whole "
                "multiples; choose a hop that divides it"
            )
