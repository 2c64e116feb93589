"""A function of time, computed for several of its future times at once.

What depends on time alone is cheap: it is a few hundred numbers a sample. Between two samples,
however, the image's megabytes push code and data out of the processor's cache, so that the same
computation takes two to four times as long as in a loop (measured).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

Time = TypeVar("Time", int, float)
Value = TypeVar("Value")

BLOCK = 16
"""Number of times whose values are computed at once (measured: 8 and 32 cost the same)."""


class ComputedAhead(Generic[Time, Value]):
    """Values of a function of time, of which a block is computed and kept at once."""

    def __init__(self, function: Callable[[Time], Value], times: Sequence[Time]) -> None:
        """Compute nothing yet.

        Args:
            function: function of time whose values own their arrays.
            times: times at which values will be asked for, increasing.
        """
        self._function: Callable[[Time], Value] = function
        self._times: Sequence[Time] = times
        self._known: dict[Time, Value] = {}

    def at(self, time: Time) -> Value:
        """Return the value at a time, also at one that was not announced."""
        if time not in self._known:
            first = bisect_left(self._times, time)
            block = self._times[first : first + BLOCK]
            if not block or block[0] != time:
                return self._function(time)
            self._known = {ahead: self._function(ahead) for ahead in block}
        return self._known[time]
