"""Spans of time in which the steps of a detector name one direction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from flybench.direction import Direction

LEAST_SPAN_US = 50_000
"""Least time that the steps of a span cover [µs]: Δt of the paper, from one response to the
next."""

GAP_US = 100_000
"""Longest time without a direction inside a span [µs]: twice Δt of the paper (assumed)."""

PAUSE_US = 1_000_000
"""A longer time between two steps is a pause in the recording and ends a span [µs] (assumed)."""


@dataclass(frozen=True)
class Span:
    """A span of time in which every step that names a direction names the same one.

    Attributes:
        direction: the direction.
        from_us: start of the first step that names it [µs].
        to_us: end of the last step that names it [µs].
        steps: number of steps that name it.
        covered_us: time that these steps cover [µs].
    """

    direction: Direction
    from_us: int
    to_us: int
    steps: int = 0
    covered_us: int = 0


class SpanFinder:
    """Finds spans while steps come in.

    A span ends with a step in another direction, after `GAP_US` without a direction, and at a
    pause. Spans whose steps cover less than `LEAST_SPAN_US` are dropped.
    """

    def __init__(self) -> None:
        self._complete: list[Span] = []
        self._open: Span | None = None
        self._still_us = 0
        self._now_us: int | None = None

    def add(self, t_us: int, direction: Direction, *, start_us: int) -> None:
        """Include the next step.

        Args:
            t_us: end of the step [µs].
            direction: its direction.
            start_us: start of the recording, from which the first step lasts [µs].
        """
        step_us = t_us - (start_us if self._now_us is None else self._now_us)
        self._now_us = t_us
        if step_us > PAUSE_US:
            self._close()
            step_us = 0
        if direction is Direction.NONE:
            self._still_us += step_us
            if self._still_us > GAP_US:
                self._close()
            return
        self._still_us = 0
        if self._open is None or self._open.direction is not direction:
            self._close()
            self._open = Span(direction, t_us - step_us, t_us)
        span = self._open
        self._open = replace(
            span, to_us=t_us, steps=span.steps + 1, covered_us=span.covered_us + step_us
        )

    @property
    def spans(self) -> Sequence[Span]:
        """Spans so far, in order of time."""
        return [*self._complete, *self._long_enough()]

    def _close(self) -> None:
        self._complete += self._long_enough()
        self._open = None

    def _long_enough(self) -> list[Span]:
        """Return the open span if its steps cover enough time."""
        span = self._open
        return [span] if span is not None and span.covered_us >= LEAST_SPAN_US else []
