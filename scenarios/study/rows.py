"""The table of the study: one row for each sequence, method and seed."""

from __future__ import annotations

from collections.abc import Iterable
from statistics import fmean, stdev
from typing import Any

from detector.estimate import MotionEstimate
from detector.metrics import within
from flybench.direction import Direction
from scenarios.pipeline.scoring import SETTLING_US
from scenarios.study.results import MethodRun, SequenceResult

Row = dict[str, Any]
_FEWEST_STEPS = 2

COLUMNS = (
    "sequence",
    "lighting",
    "background",
    "sensor",
    "omega_rad_s",
    "speed_km_h",
    "image_speed_px_s",
    "duration_s",
    "truth",
    "method",
    "seed",
    "verdict",
    "accuracy",
    "accuracy_after_100ms",
    "opposite_after_100ms",
    "sideways_after_100ms",
    "none_after_100ms",
    "steps_in_view",
    "latency_ms",
    "response_mean",
    "response_variation",
    "velocity_error_px_s",
    "velocity_bias_px_s",
    "roi_iou",
    "centroid_error_px",
    "grms",
    "cpu_s",
    "ms_per_estimate",
    "ns_per_event",
    "events",
    "estimates",
)
"""Columns of the table, in order.

- sequence: see `scenarios.study.results.sequence_name`; also names the recording.
- background and sensor: see `scenarios.study.conditions`.
- image_speed_px_s: image speed of the vehicle at closest approach.
- truth: true direction.
- verdict: direction that the method finds over the whole crossing.
- accuracy to latency_ms, and grms: see `scenarios.pipeline.scoring.score_estimates`.
- response_mean: HS or VS along the true direction, mean over the steps after 100 ms.
- response_variation: standard deviation of that response over its mean; None if the mean is not
  above 0.
- velocity_error_px_s and velocity_bias_px_s: see `MethodRun`.
- roi_iou and centroid_error_px: None for a method without a region of interest.
- cpu_s: CPU time of all calls.
- ms_per_estimate and ns_per_event: CPU time by estimates, and by events given to the method.
"""


def study_rows(sequences: Iterable[SequenceResult]) -> list[Row]:
    """Return the rows, in the order of the sequences and of their runs."""
    return [_row(sequence, run) for sequence in sequences for run in sequence.runs]


def _row(sequence: SequenceResult, run: MethodRun) -> Row:
    scores = dict(run.scores)
    if not any(e.roi_px is not None for e in run.estimates):
        scores["roi_iou"] = scores["centroid_error_px"] = None
    mean, variation = response(sequence, run)
    values: Row = {
        "sequence": sequence.name,
        "lighting": sequence.lighting,
        "background": sequence.background,
        "sensor": run.sensor,
        "omega_rad_s": sequence.omega_rad_s,
        "speed_km_h": sequence.speed_km_h,
        "image_speed_px_s": sequence.image_speed_px_s,
        "duration_s": sequence.duration_us / 1e6,
        "truth": sequence.direction,
        "method": run.method,
        "seed": run.seed,
        "verdict": scores.pop("direction"),
        **scores,
        "response_mean": mean,
        "response_variation": variation,
        "velocity_error_px_s": run.velocity_error_px_s,
        "velocity_bias_px_s": run.velocity_bias_px_s,
        "cpu_s": run.cpu_s,
        "ms_per_estimate": _ratio(1e3 * run.cpu_s, len(run.estimates)),
        "ns_per_event": _ratio(1e9 * run.cpu_s, run.events),
        "events": run.events,
        "estimates": len(run.estimates),
    }
    return {name: values[name] for name in COLUMNS}


def response(sequence: SequenceResult, run: MethodRun) -> tuple[float | None, float | None]:
    """Return the mean and the variation of a method's response along the true direction.

    Only the steps after 100 ms in view count.

    Returns:
        Mean; None without steps. Standard deviation over mean; None with fewer than two steps, or
        if the mean is not above 0.
    """
    settled_us = sequence.in_view_us[0] + SETTLING_US, sequence.in_view_us[1]
    along = [_along(e, sequence.direction) for e in within(run.estimates, settled_us)]
    mean = fmean(along) if along else None
    if mean is None or mean <= 0.0 or len(along) < _FEWEST_STEPS:
        return mean, None
    return mean, stdev(along) / mean


def _along(estimate: MotionEstimate, direction: str) -> float:
    is_horizontal = direction in (Direction.RIGHT, Direction.LEFT)
    sign = 1.0 if direction in (Direction.RIGHT, Direction.DOWN) else -1.0
    return sign * (estimate.hs if is_horizontal else estimate.vs)


def _ratio(value: float, number: int) -> float | None:
    return value / number if number else None
