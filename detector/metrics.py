"""How well a detector did on one crossing, against the true direction.

A crossing is a pair (enters, leaves) of times [µs]. An estimate belongs to it when its window ends
after the vehicle entered and no later than it left: enters < t ≤ leaves.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left
from collections.abc import Sequence

from detector.errors import DetectorError
from detector.estimate import MotionEstimate
from detector.fly.model_variants import GrmsOf
from flybench.direction import Direction

Estimates = Sequence[MotionEstimate]
Box = tuple[int, int, int, int]
"""x0, y0, x1, y1, half-open [px]."""
Point = tuple[float, float]
"""x, y in continuous pixel coordinates [px]."""

GRMS_STEP_US = 50_000
"""The paper's Δt: the step from one response to the next in its equations [µs]."""


def within(estimates: Estimates, crossing_us: tuple[int, int]) -> list[MotionEstimate]:
    """The estimates that belong to a crossing."""
    enters_us, leaves_us = crossing_us
    return [e for e in estimates if enters_us < e.t_us <= leaves_us]


def accuracy(
    estimates: Estimates, truth: Direction, *, crossing_us: tuple[int, int]
) -> float | None:
    """Share of the steps whose direction is right, in [0, 1]; none counts as wrong.

    Args:
        estimates: of the whole sequence.
        truth: true direction.
        crossing_us: when the vehicle entered and left the view [µs].

    Returns:
        The share, or None where no estimate belongs to the crossing.
    """
    steps = within(estimates, crossing_us)
    if not steps:
        return None
    return sum(e.direction is truth for e in steps) / len(steps)


def verdict(estimates: Estimates, *, crossing_us: tuple[int, int]) -> Direction:
    """The one direction of a crossing: the one with most strength, summed over the steps.

    Returns:
        A direction, or none where no step names one.
    """
    strengths: dict[Direction, float] = {}
    for e in within(estimates, crossing_us):
        if e.direction is not Direction.NONE:
            strengths[e.direction] = strengths.get(e.direction, 0.0) + e.strength
    return max(strengths, key=strengths.__getitem__, default=Direction.NONE)


def grms(
    estimates: Estimates,
    *,
    crossing_us: tuple[int, int],
    of: GrmsOf = GrmsOf.WINNER,
    step_us: int = GRMS_STEP_US,
) -> float | None:
    """Gradient root mean square of the response before normalisation (paper, figure 5 B).

    A gradient is the difference from a step to the first that comes `step_us` later or more, over
    the time between: as a vector, so that it does not depend on the direction of motion.

    Args:
        estimates: of the whole sequence, in order of time.
        crossing_us: when the vehicle entered and left the view [µs].
        of: which response; `GrmsOf` says what either reading gives.
        step_us: least time that a gradient spans [µs].

    Returns:
        The figure in responses per second, or None where no two steps are that far apart.

    Raises:
        DetectorError: a step is no later than the one before.
    """
    steps = within(estimates, crossing_us)
    times_us = [e.t_us for e in steps]
    for before_us, after_us in itertools.pairwise(times_us):
        if after_us <= before_us:
            raise DetectorError(
                f"an estimate at {after_us} µs follows one at {before_us} µs; allowed is a "
                "t_us that rises from each to the next; sort them, and keep one a time"
            )
    responses = [_put_out(e.response, of) for e in steps]
    squares = []
    for n, start_us in enumerate(times_us):
        later = max(bisect_left(times_us, start_us + step_us), n + 1)
        if later < len(steps):
            seconds = (times_us[later] - start_us) * 1e-6
            squares.append((math.dist(responses[n], responses[later]) / seconds) ** 2)
    return math.sqrt(math.fsum(squares) / len(squares)) if squares else None


def _put_out(response: tuple[float, float], of: GrmsOf) -> tuple[float, float]:
    """Horizontal and vertical response as the model gives them out."""
    horizontal, vertical = response
    if of is GrmsOf.BOTH:
        return response
    return (horizontal, 0.0) if abs(horizontal) >= abs(vertical) else (0.0, vertical)


def onset_latency_us(
    estimates: Estimates, truth: Direction, *, crossing_us: tuple[int, int]
) -> int | None:
    """Time from the vehicle's entry to the first right decision [µs]; None if there is none."""
    right = [e.t_us for e in within(estimates, crossing_us) if e.direction is truth]
    return right[0] - crossing_us[0] if right else None


def intersection_over_union(first: Box | None, second: Box | None) -> float:
    """Overlap of two boxes: area of the intersection over that of the union, in [0, 1].

    Args:
        first: (x0, y0, x1, y1), half-open [px]; None: no box, which overlaps with none.
        second: the same.
    """
    if first is None or second is None:
        return 0.0
    wide = min(first[2], second[2]) - max(first[0], second[0])
    high = min(first[3], second[3]) - max(first[1], second[1])
    shared = max(wide, 0) * max(high, 0)
    union = _area(first) + _area(second) - shared
    return shared / union if union else 0.0


def centroid_error_px(view_centre: Point, centroid: Point) -> float:
    """Distance from where attention rests to the true centroid, both (x, y) [px]."""
    return math.dist(view_centre, centroid)


def _area(box: Box) -> int:
    return (box[2] - box[0]) * (box[3] - box[1])
