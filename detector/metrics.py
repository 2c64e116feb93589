"""Measures of a detector's performance on one crossing, against the true direction.

A crossing is a pair (enters, leaves) of times [µs]. An estimate belongs to it if its window ends
after the vehicle has entered and not after it has left: enters < t ≤ leaves. An estimate that
belongs to a crossing is called a step.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left
from collections.abc import Sequence

from detector.errors import DetectorError
from detector.estimate import MotionEstimate
from detector.fly.model_variants import GrmsResponse
from flybench.direction import Direction

Estimates = Sequence[MotionEstimate]
Box = tuple[int, int, int, int]
"""x0, y0, x1, y1, half-open [px]."""
Point = tuple[float, float]
"""x, y in continuous pixel coordinates [px]."""

GRMS_STEP_US = 50_000
"""Δt of the paper: the step from one response to the next in its equations [µs]."""


def within(estimates: Estimates, crossing_us: tuple[int, int]) -> list[MotionEstimate]:
    """Return the estimates that belong to a crossing."""
    enters_us, leaves_us = crossing_us
    return [e for e in estimates if enters_us < e.t_us <= leaves_us]


def accuracy(
    estimates: Estimates, truth: Direction, *, crossing_us: tuple[int, int]
) -> float | None:
    """Return the share of steps with the right direction, in [0, 1]; `NONE` counts as wrong.

    Args:
        estimates: all estimates of the sequence.
        truth: true direction.
        crossing_us: times at which the vehicle enters and leaves the view [µs].

    Returns:
        The share, or None if no estimate belongs to the crossing.
    """
    steps = within(estimates, crossing_us)
    if not steps:
        return None
    return sum(e.direction is truth for e in steps) / len(steps)


def verdict(estimates: Estimates, *, crossing_us: tuple[int, int]) -> Direction:
    """Return the direction with the largest total strength over all steps of a crossing.

    Returns:
        A direction, or `NONE` if every step is `NONE`.
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
    of: GrmsResponse = GrmsResponse.WINNER,
    step_us: int = GRMS_STEP_US,
) -> float | None:
    """Return the gradient root mean square of the raw response (paper, Fig. EX3 B).

    A gradient is the difference between the response at a step and at the first step that comes at
    least `step_us` later, divided by the time between them. It is taken as a vector, so that it
    does not depend on the direction of motion.

    Args:
        estimates: all estimates of the sequence, in order of time.
        crossing_us: times at which the vehicle enters and leaves the view [µs].
        of: which response to use; `detector.fly.model_variants` compares the choices.
        step_us: least time that a gradient spans [µs].

    Returns:
        Responses per second, or None if no two steps are `step_us` apart.

    Raises:
        DetectorError: a step is not later than the one before.
    """
    steps = within(estimates, crossing_us)
    times_us = [e.t_us for e in steps]
    _check_rising(times_us)
    responses = [_model_output(e.response, of) for e in steps]
    squares = []
    for n, start_us in enumerate(times_us):
        later = max(bisect_left(times_us, start_us + step_us), n + 1)
        if later < len(steps):
            seconds = (times_us[later] - start_us) * 1e-6
            squares.append((math.dist(responses[n], responses[later]) / seconds) ** 2)
    return math.sqrt(math.fsum(squares) / len(squares)) if squares else None


def _check_rising(times_us: list[int]) -> None:
    for before_us, after_us in itertools.pairwise(times_us):
        if after_us <= before_us:
            raise DetectorError(
                f"An estimate at {after_us} µs follows one at {before_us} µs. Allowed are times "
                "that rise from each estimate to the next. Sort them and keep one for each time."
            )


def _model_output(response: tuple[float, float], of: GrmsResponse) -> tuple[float, float]:
    """Return the response, with the weaker system set to 0 if only the winner counts."""
    horizontal, vertical = response
    if of is GrmsResponse.BOTH:
        return response
    return (horizontal, 0.0) if abs(horizontal) >= abs(vertical) else (0.0, vertical)


def onset_latency_us(
    estimates: Estimates, truth: Direction, *, crossing_us: tuple[int, int]
) -> int | None:
    """Return the time from the vehicle's entry to the first right step [µs]; None without one."""
    right = [e.t_us for e in within(estimates, crossing_us) if e.direction is truth]
    return right[0] - crossing_us[0] if right else None


def intersection_over_union(first: Box | None, second: Box | None) -> float:
    """Return the intersection over union of two boxes, in [0, 1].

    Args:
        first: (x0, y0, x1, y1), half-open [px]; None is an empty box.
        second: the other box.
    """
    if first is None or second is None:
        return 0.0
    width = min(first[2], second[2]) - max(first[0], second[0])
    height = min(first[3], second[3]) - max(first[1], second[1])
    shared = max(width, 0) * max(height, 0)
    union = _area(first) + _area(second) - shared
    return shared / union if union else 0.0


def centroid_error_px(view_centre: Point, centroid: Point) -> float:
    """Return the distance from the view centre to the true centroid, both (x, y) [px]."""
    return math.dist(view_centre, centroid)


def _area(box: Box) -> int:
    return (box[2] - box[0]) * (box[3] - box[1])
