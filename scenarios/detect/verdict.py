"""The verdict on a recording: the one direction that its steps name, or why there is none.

Nobody knows when the moving object of a recording entered and left the view, so that the verdict
uses all steps. A step is one estimate.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from detector.estimate import Detector
from flybench.direction import Direction
from scenarios.detect.run_detector import RecordingSlice
from scenarios.detect.spans import GAP_US, LEAST_SPAN_US, Span, SpanFinder
from scenarios.errors import MethodError

LEAST_SHARE = 0.8
"""Least share of the steps with a direction that has to name the verdict (assumed)."""

STILL_SHARE = 0.01
"""Greatest share of steps with a direction if nothing moves: the fly names one in at most 0.5 % of
the steps in noise (docs/explanation/no-motion.md), and 1 % leaves a margin (assumed)."""

TOO_SHORT, STILL, CHANGES, UNCLEAR = (
    "too short to judge",
    "nothing moves",
    "changes",
    "unclear",
)


class RecordingVerdict:
    """Counts steps by direction, finds spans of one direction, and judges the recording.

    Attributes:
        counts: number of steps by direction, `NONE` included.
        memory_us: age of the oldest event in an estimate of the detector [µs]; 0: unknown.
    """

    def __init__(self, memory_us: int = 0) -> None:
        self.counts: Counter[Direction] = Counter(dict.fromkeys(Direction, 0))
        self.memory_us = memory_us
        self._span_finder = SpanFinder()
        self._length_us = 0

    def add(self, part: RecordingSlice) -> None:
        """Include the estimates of a slice of the recording."""
        for estimate in part.estimates:
            t_us = int(estimate.t_us)
            self.counts[estimate.direction] += 1
            self._length_us = t_us - part.start_us
            self._span_finder.add(t_us, estimate.direction, start_us=part.start_us)

    @property
    def steps(self) -> int:
        """Number of steps."""
        return self.counts.total()

    @property
    def moving(self) -> int:
        """Number of steps that name a direction."""
        return self.steps - self.counts[Direction.NONE]

    @property
    def shares(self) -> Mapping[Direction, float]:
        """Share of all steps by direction, 0 to 1; 0 if there are no steps."""
        return {d: n / self.steps if self.steps else 0.0 for d, n in self.counts.items()}

    @property
    def shares_text(self) -> str:
        """Shares of all steps by direction."""
        return ", ".join(f"{percent(share)} {d.value}" for d, share in self.shares.items())

    @property
    def spans(self) -> Sequence[Span]:
        """Spans of time with one direction, in order of time."""
        return self._span_finder.spans

    @property
    def leading(self) -> Direction:
        """Direction that most steps name; `NONE` if no step names one."""
        moving = {d: n for d, n in self.counts.items() if n and d is not Direction.NONE}
        return max(moving, key=moving.__getitem__, default=Direction.NONE)

    @property
    def share(self) -> float:
        """Share of `leading` in the steps that name a direction, 0 to 1; 0 if none does."""
        return self.counts[self.leading] / self.moving if self.moving else 0.0

    @property
    def word(self) -> str:
        """The verdict: a direction, `TOO_SHORT`, `STILL`, `CHANGES` or `UNCLEAR`."""
        directions = {span.direction for span in self.spans}
        if not self.steps or self._length_us < self.memory_us:
            return TOO_SHORT
        if not directions and self.moving <= STILL_SHARE * self.steps:
            return STILL
        if self.share >= LEAST_SHARE and self.leading in directions:
            return self.leading.value
        return CHANGES if len(directions) > 1 else UNCLEAR

    @property
    def direction(self) -> Direction:
        """The verdict if it is a direction; otherwise `NONE`."""
        return self.leading if self.word == self.leading.value else Direction.NONE

    @property
    def reason(self) -> str:
        """The figures behind the verdict."""
        named = f"{self.moving:,} of {self.steps:,} steps name a direction"
        if self.word == TOO_SHORT:
            length_s, memory_s = self._length_us * 1e-6, self.memory_us * 1e-6
            return f"{named}; {length_s:.3g} s long, the method looks back {memory_s:g} s"
        if self.word == STILL:
            return named
        lead = f"{named}, {self.counts[self.leading]:,} of these {self.leading.value}"
        return lead if self.spans else f"{lead}, and none holds for {LEAST_SPAN_US * 1e-6:g} s"

    def to_json(self) -> dict[str, Any]:
        """Return the verdict, what it is made of, and its limits."""
        return {
            "verdict": self.word,
            "reason": self.reason,
            "direction": self.direction.value,
            "share": self.share,
            "counts": {d.value: n for d, n in self.counts.items()},
            "shares": {d.value: share for d, share in self.shares.items()},
            "spans": [
                {"direction": s.direction.value, "from_us": s.from_us, "to_us": s.to_us}
                | {"steps": s.steps}
                for s in self.spans
            ],
            "limits": {
                "least_share": LEAST_SHARE,
                "still_share": STILL_SHARE,
                "least_span_us": LEAST_SPAN_US,
                "gap_us": GAP_US,
                "memory_us": self.memory_us,
            },
        }


def percent(share: float) -> str:
    """Format a share as a percentage, so that only 0 and 1 read "0 %" and "100 %"."""
    if 0.0 < share < 0.005:
        return "< 1 %"
    return "> 99 %" if 0.995 <= share < 1.0 else f"{100 * share:.0f} %"


def memory_us(detector: Detector) -> int:
    """Return how far back a detector looks [µs]; 0 for a class that does not state `memory_us`.

    Raises:
        MethodError: the attribute is not a whole number of 0 or more.
    """
    value: Any = getattr(detector, "memory_us", 0)
    if type(value) is not int or value < 0:
        raise MethodError(
            f"{type(detector).__name__}.memory_us is {value!r}. Allowed is a whole number of µs, 0 "
            "or more. Correct the attribute, or remove it."
        )
    return value
