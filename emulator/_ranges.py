"""The check that configurations share."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Integral, Real

from emulator.errors import SensorConfigError

Range = tuple[float, float, str]
"""Least and greatest value allowed, and the remedy that a refusal suggests."""


def check_ranges(config: object, ranges: Mapping[str, Range]) -> None:
    """Refuse a configuration with a number outside its range.

    A range whose bounds are both integers asks for an integer.

    Args:
        config: object with the named attributes.
        ranges: allowed range of each attribute.

    Raises:
        SensorConfigError: names the attribute, its value, the range and the remedy.
    """
    for name, (low, high, remedy) in ranges.items():
        value = getattr(config, name)
        whole = isinstance(low, int) and isinstance(high, int)
        kind, noun = (Integral, "a whole number") if whole else (Real, "a number")
        numeric = isinstance(value, kind) and not isinstance(value, bool)
        if not numeric or not low <= float(value) <= high:
            raise SensorConfigError(
                f"{name} is {value!r}; allowed is {noun} from {low:g} to {high:g}; {remedy}"
            )
