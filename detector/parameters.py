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
    for name, (low, high) in ranges.items():
        value, default = getattr(config, name), defaults[name]
        is_whole = isinstance(default, int)
        kind: type = Integral if is_whole else Real
        is_number = isinstance(value, kind) and not isinstance(value, bool)
        if not (is_number and low <= value <= high):
            whole = "a whole number from " if is_whole else ""
            raise DetectorConfigError(
                f"{name} is {value!r}; allowed is {whole}{low:g} to {high:g}; the default is "
                f"{default}"
            )
        object.__setattr__(config, name, int(value) if is_whole else float(value))
