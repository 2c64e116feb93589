"""Checks of configuration values, for every package."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from numbers import Integral, Real
from typing import Any, TypeVar

from flybench.errors import FlybenchError

Member = TypeVar("Member", bound=StrEnum)


@dataclass(frozen=True)
class Range:
    """The range of a number; a whole number if both bounds are integers.

    Attributes:
        low: lowest allowed value.
        high: highest allowed value.
        unit: unit of the value, for the message; empty for a pure number.
        remedy: sentence with an instruction for the user; None: the message gives the default.
        optional: True if None is allowed too.
    """

    low: float
    high: float
    unit: str = ""
    remedy: str | None = None
    optional: bool = False

    def check(
        self, name: str, value: Any, error: type[FlybenchError], *, default: Any = None
    ) -> Any:
        """Return the value as a Python int or float, or None where that is allowed.

        Args:
            name: name of the parameter, for the message.
            value: candidate.
            error: class to raise.
            default: default of the parameter, for the message; None: not mentioned.

        Raises:
            FlybenchError: of class `error`, if the value has another type or is out of range.
        """
        if value is None and self.optional:
            return None
        whole = isinstance(self.low, int) and isinstance(self.high, int)
        kind: type = Integral if whole else Real
        is_number = isinstance(value, kind) and not isinstance(value, bool)
        if is_number and self.low <= value <= self.high:
            return int(value) if whole else float(value)
        noun = "a whole number" if whole else "a number"
        allowed = f"{noun} from {self.low:.10g} to {self.high:.10g} {self.unit}".rstrip()
        remedy = self.remedy
        if remedy is None:
            remedy = "Choose a value in that range." if default is None else ""
        if default is not None:
            remedy = f"{remedy} The default is {default!r}.".lstrip()
        raise error(f"{name} is {value!r}. Allowed is {allowed}. {remedy}")


def check_ranges(config: Any, ranges: Mapping[str, Range], error: type[FlybenchError]) -> None:
    """Check numbers of a frozen dataclass, and convert NumPy's numbers to Python's.

    Args:
        config: the dataclass; call this from its `__post_init__`.
        ranges: range of each field to check.
        error: class to raise.

    Raises:
        FlybenchError: of class `error`, for the first field out of its range.
    """
    defaults = {field.name: field.default for field in fields(config)}
    for name, allowed in ranges.items():
        default = defaults[name] if isinstance(defaults[name], int | float) else None
        value = allowed.check(name, getattr(config, name), error, default=default)
        object.__setattr__(config, name, value)


def member(
    kind: type[Member],
    name: str,
    value: Any,
    error: type[FlybenchError],
    *,
    without: Collection[Member] = (),
) -> Member:
    """Return the member of an enumeration that `value` names.

    Args:
        kind: the enumeration.
        name: name of the parameter, for the message.
        value: a member or its value.
        error: class to raise.
        without: members that this parameter does not take.

    Raises:
        FlybenchError: of class `error`, if there is no such member.
    """
    allowed = [item for item in kind if item not in without]
    if value in allowed:
        return kind(value)
    shown = value.value if isinstance(value, StrEnum) else value
    raise error(f"{name} is {shown!r}. Allowed is one of {', '.join(allowed)}. Choose one of them.")
