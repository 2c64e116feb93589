"""Values over time, each valid until the next one."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(eq=False)
class Track(Generic[T]):
    """Values over time.

    Attributes:
        t_us: times, in ascending order [µs].
        values: the value from each time until the next.
    """

    t_us: list[int] = field(default_factory=list)
    values: list[T] = field(default_factory=list)

    def add(self, t_us: int, value: T) -> None:
        """Add the next value."""
        self.t_us.append(t_us)
        self.values.append(value)

    def at(self, t_us: int) -> T | None:
        """Return the value at a time; None before the first."""
        index = bisect_right(self.t_us, t_us) - 1
        return self.values[index] if index >= 0 else None
