"""How a configuration's values are refused: by name, with what is allowed and what to do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeVar

from sim.errors import SceneConfigError

E = TypeVar("E", bound=StrEnum)


@dataclass(frozen=True)
class Range:
    """What a number may be.

    Attributes:
        low: smallest.
        high: largest.
        unit: as written after a number; "whole" for whole numbers.
        remedy: what to do about another value.
    """

    low: float
    high: float
    unit: str
    remedy: str = "choose a value in that range"

    def check(self, name: str, value: Any) -> None:
        """Refuse a value outside.

        Raises:
            SceneConfigError: it is too small, too large, or no number of the kind.
        """
        kind = int if self.unit == "whole" else (int, float)
        is_number = isinstance(value, kind) and not isinstance(value, bool)
        if is_number and self.low <= value <= self.high:
            return
        allowed = f"{self.low:g} to {self.high:.10g} {self.unit}".rstrip()
        raise SceneConfigError(f"{name} is {value!r}; allowed is {allowed}; {self.remedy}")


def check_ranges(ranges: Mapping[str, Range], values: Mapping[str, Any]) -> None:
    """Refuse the first of some values that is outside its range.

    Raises:
        SceneConfigError: one is.
    """
    for name, allowed in ranges.items():
        allowed.check(name, values[name])


def member(kind: type[E], name: str, value: Any) -> E:
    """The member of `kind` that `value` names.

    Raises:
        SceneConfigError: there is none.
    """
    try:
        return kind(value)
    except ValueError:
        allowed = ", ".join(kind)
        raise SceneConfigError(
            f"{name} is {value!r}; allowed is one of {allowed}; choose one of them"
        ) from None
