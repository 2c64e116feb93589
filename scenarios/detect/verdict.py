"""The verdict on a recording: the one direction that its estimates indicate."""

from __future__ import annotations

from detector.estimate import MotionEstimate
from flybench.direction import Direction


class RecordingVerdict:
    """The direction with the largest strength, summed over all estimates that name it.

    This is `detector.metrics.verdict` over all estimates, because nobody knows when the moving
    object of a recording entered and left the view.

    Attributes:
        steps: number of estimates so far.
        strengths: sum of the strengths by direction.
        counts: number of estimates by direction.
    """

    def __init__(self) -> None:
        self.steps = 0
        self.strengths: dict[Direction, float] = {}
        self.counts: dict[Direction, int] = {}

    def add(self, estimate: MotionEstimate) -> None:
        """Include an estimate."""
        direction = estimate.direction
        self.steps += 1
        self.counts[direction] = self.counts.get(direction, 0) + 1
        if direction is not Direction.NONE:
            self.strengths[direction] = self.strengths.get(direction, 0.0) + estimate.strength

    @property
    def direction(self) -> Direction:
        """The verdict; `NONE` if no estimate names a direction."""
        return max(self.strengths, key=self.strengths.__getitem__, default=Direction.NONE)

    @property
    def share(self) -> float:
        """Share of the verdict in the strength of all directions, 0 to 1; 0 if it is `NONE`."""
        total = sum(self.strengths.values())
        return self.strengths[self.direction] / total if total else 0.0
