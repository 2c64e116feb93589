"""Scores of a detector's estimates over one crossing, against the ground truth."""

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
"""Time in view after which a detector should have found the direction [µs]: twice the paper's
Δt."""


class Target(Protocol):
    """Ground truth of where the target is."""

    def box_px(self, t_us: int) -> Box | None:
        """Return the bounding box of the visible part at a time; None if it is out of view."""
        ...

    def centroid_px(self, t_us: int) -> Point | None:
        """Return the centroid of the visible part at a time; None if it is out of view."""
        ...


@dataclass
class TargetTrack:
    """A `Target` that is known at samples; each sample holds until the next one."""

    _times_us: list[int] = field(default_factory=list)
    _boxes: list[Box | None] = field(default_factory=list)
    _centroids: list[Point | None] = field(default_factory=list)

    def add(self, t_us: int, box: Box | None, centroid: Point | None) -> None:
        """Add the next sample; box and centroid are None if the target is out of view."""
        self._times_us.append(t_us)
        self._boxes.append(box)
        self._centroids.append(centroid)

    @property
    def in_view_us(self) -> tuple[int, int]:
        """First and last time at which the target is in view [µs]; (0, 0) if it never is."""
        visible = [t for t, box in zip(self._times_us, self._boxes, strict=True) if box is not None]
        return (visible[0], visible[-1]) if visible else (0, 0)

    def box_px(self, t_us: int) -> Box | None:
        """Return the bounding box at a time; None if out of view or before the first sample."""
        n = bisect_right(self._times_us, t_us) - 1
        return None if n < 0 else self._boxes[n]

    def centroid_px(self, t_us: int) -> Point | None:
        """Return the centroid at a time; None if out of view or before the first sample."""
        n = bisect_right(self._times_us, t_us) - 1
        return None if n < 0 else self._centroids[n]


def score_estimates(
    estimates: Sequence[MotionEstimate],
    direction: str,
    in_view_us: tuple[int, int],
    target: Target,
) -> dict[str, Any]:
    """Compare the estimates of a detector over a crossing with the ground truth.

    Args:
        estimates: all estimates of the detector.
        direction: true direction.
        in_view_us: first and last time at which the target is in view [µs].
        target: ground truth of the target's position.

    Returns:
        A dictionary of scores. A "step" is one estimate.

        - direction: verdict of the detector over the steps in view.
        - accuracy: share of the steps in view with the correct direction.
        - accuracy_after_100ms: the same share, over steps at least 100 ms after the target came
          into view.
        - opposite_after_100ms, sideways_after_100ms, none_after_100ms: shares of these steps with
          the wrong sign, the wrong axis, and no direction.
        - steps_in_view: number of steps in view.
        - latency_ms: time from the first visible pixel to the first correct step. None if no step
          is correct, or if the target is in view from t = 0, when its entry time is unknown.
        - roi_iou: mean overlap (IoU) of the region of interest with the target's bounding box, over
          the steps after 100 ms. A step without a region counts as 0. None if no estimate at all
          has a region.
        - centroid_error_px: mean distance from the view centre to the target's centroid, over the
          same steps.
        - grms: GRMS of the response [1/s]; see `metrics.grms`.
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
    """Return the shares of incorrect steps by kind of error."""
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
