"""What a detector said over one crossing, against the truth."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from statistics import fmean
from typing import Any, Protocol

from detector.estimate import MotionEstimate
from detector.metrics import (
    Box,
    Point,
    accuracy,
    centroid_error_px,
    grms,
    intersection_over_union,
    onset_latency_us,
    verdict,
    within,
)
from flybench.direction import Direction

SETTLING_US = 100_000
"""After this long in view a direction is due: two windows of the paper's Δt."""


class Target(Protocol):
    """Where the target really is."""

    def box_px(self, t_us: int) -> Box | None:
        """The box of what is seen of it at a time; None where it is out of view."""
        ...

    def centroid_px(self, t_us: int) -> Point | None:
        """The middle of what is seen of it at a time; None where it is out of view."""
        ...


@dataclass
class Track:
    """A `Target` known at samples: each holds until the next."""

    _times_us: list[int] = field(default_factory=list)
    _boxes: list[Box | None] = field(default_factory=list)
    _centroids: list[Point | None] = field(default_factory=list)

    def add(self, t_us: int, box: Box | None, centroid: Point | None) -> None:
        """Take the next sample; None where the target is out of view."""
        self._times_us.append(t_us)
        self._boxes.append(box)
        self._centroids.append(centroid)

    @property
    def in_view_us(self) -> tuple[int, int]:
        """When the target was first and last in view [µs]; (0, 0) where it never was."""
        seen = [t for t, box in zip(self._times_us, self._boxes, strict=True) if box is not None]
        return (seen[0], seen[-1]) if seen else (0, 0)

    def box_px(self, t_us: int) -> Box | None:
        """See `Target.box_px`; None before the first sample."""
        n = bisect_right(self._times_us, t_us) - 1
        return None if n < 0 else self._boxes[n]

    def centroid_px(self, t_us: int) -> Point | None:
        """See `Target.centroid_px`; None before the first sample."""
        n = bisect_right(self._times_us, t_us) - 1
        return None if n < 0 else self._centroids[n]


def judge(
    estimates: Sequence[MotionEstimate],
    direction: str,
    in_view_us: tuple[int, int],
    target: Target,
) -> dict[str, Any]:
    """What a detector said over a crossing, against the truth.

    Args:
        estimates: all that it said.
        direction: the true one.
        in_view_us: when the target was first and last in view [µs].
        target: where it was.

    Returns:
        direction: its verdict over the steps in view; accuracy: share of those whose direction is
        right; accuracy_after_100ms and the three shares of what else was said then: opposite
        (the wrong sign), sideways (the wrong axis), none; steps_in_view; latency_ms: from the
        first pixel in view to the first right step, None where there was none, or where the target
        is in view from the start (t = 0), since then nobody knows when it entered; roi_iou: overlap
        of the region of interest with the target's box, mean over the steps after 100 ms, a step
        without a region as 0, None where no estimate of all names one; centroid_error_px: distance
        from the view centre to the target's centroid, mean over the same steps; grms: of the
        response [1/s], see `metrics.grms`.
    """
    truth = Direction(direction)
    settled_us = in_view_us[0] + SETTLING_US, in_view_us[1]
    settled = within(estimates, settled_us)
    entered = in_view_us[0] > 0
    latency_us = onset_latency_us(estimates, truth, crossing_us=in_view_us) if entered else None
    return {
        "direction": verdict(estimates, crossing_us=in_view_us).value,
        "accuracy": accuracy(estimates, truth, crossing_us=in_view_us),
        "accuracy_after_100ms": accuracy(estimates, truth, crossing_us=settled_us),
        **_mistakes(settled, truth),
        "steps_in_view": len(within(estimates, in_view_us)),
        "latency_ms": None if latency_us is None else latency_us / 1e3,
        **_attention(settled, target, has_region=any(e.roi_px is not None for e in estimates)),
        "grms": grms(estimates, crossing_us=in_view_us),
    }


OPPOSITE = {
    Direction.RIGHT: Direction.LEFT,
    Direction.LEFT: Direction.RIGHT,
    Direction.UP: Direction.DOWN,
    Direction.DOWN: Direction.UP,
}


def _mistakes(settled: Sequence[MotionEstimate], truth: Direction) -> dict[str, float | None]:
    """Shares of the steps that are not right, by how they are wrong."""
    kinds = {
        "opposite_after_100ms": {OPPOSITE[truth]},
        "sideways_after_100ms": set(Direction) - {truth, OPPOSITE[truth], Direction.NONE},
        "none_after_100ms": {Direction.NONE},
    }
    return {
        name: fmean(e.direction in kind for e in settled) if settled else None
        for name, kind in kinds.items()
    }


def _attention(
    settled: Sequence[MotionEstimate], target: Target, *, has_region: bool
) -> dict[str, float | None]:
    overlaps, errors = [], []
    for e in settled:
        box, centroid = target.box_px(e.t_us), target.centroid_px(e.t_us)
        if box is not None and centroid is not None:
            overlaps.append(intersection_over_union(e.roi_px, box))
            errors.append(centroid_error_px(e.view_centre_px, centroid))
    return {
        "roi_iou": fmean(overlaps) if overlaps and has_region else None,
        "centroid_error_px": fmean(errors) if errors else None,
    }
