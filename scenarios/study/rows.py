"""The study's table: one row a sequence, method and seed."""

from __future__ import annotations

from collections.abc import Iterable
from statistics import fmean, stdev
from typing import Any

from detector.estimate import MotionEstimate
from detector.metrics import within
from flybench.direction import Direction
from scenarios.pipeline.scoring import SETTLING_US
from scenarios.study.results import MethodRun, Sequence

Row = dict[str, Any]
_LEAST_STEPS = 2

COLUMNS = (
    "sequence",
    "lighting",
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
"""What a row holds, in order.

sequence: light and velocity, such as "day_1.21", which also names its recording; truth: the true
direction; image_speed_px_s: the vehicle's, when it is nearest; from accuracy to latency_ms, and
grms: see `scenarios.pipeline.scoring.score_estimates`; response_mean: HS or VS along the true
direction, mean over the steps after 100 ms; response_variation: its standard deviation over that
mean, None where the mean is not above 0; velocity_error_px_s and velocity_bias_px_s: see
`MethodRun`;
roi_iou and centroid_error_px: of a method that attends to a place, None of one that does not;
cpu_s: of all calls; ms_per_estimate and ns_per_event: that, by estimates and by events shown.
"""


def study_rows(sequences: Iterable[Sequence]) -> list[Row]:
    """The table, in the order of the sequences and of their runs."""
    return [_row(sequence, run) for sequence in sequences for run in sequence.runs]


def _row(sequence: Sequence, run: MethodRun) -> Row:
    found = dict(run.judgement)
    if not any(e.roi_px is not None for e in run.estimates):
        found["roi_iou"] = found["centroid_error_px"] = None
    mean, variation = response(sequence, run)
    values: Row = {
        "sequence": sequence.name,
        "lighting": sequence.lighting,
        "omega_rad_s": sequence.omega_rad_s,
        "speed_km_h": sequence.speed_km_h,
        "image_speed_px_s": sequence.image_speed_px_s,
        "duration_s": sequence.duration_us / 1e6,
        "truth": sequence.direction,
        "method": run.method,
        "seed": run.seed,
        "verdict": found.pop("direction"),
        **found,
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


def response(sequence: Sequence, run: MethodRun) -> tuple[float | None, float | None]:
    """How strong a method's response along the true direction is once settled, and how uneven.

    Returns:
        Mean, and standard deviation over mean; None where there are too few steps, and the latter
        where the mean is not above 0.
    """
    settled_us = sequence.in_view_us[0] + SETTLING_US, sequence.in_view_us[1]
    along = [_along(e, sequence.direction) for e in within(run.estimates, settled_us)]
    mean = fmean(along) if along else None
    if mean is None or mean <= 0.0 or len(along) < _LEAST_STEPS:
        return mean, None
    return mean, stdev(along) / mean


def _along(estimate: MotionEstimate, direction: str) -> float:
    level = direction in (Direction.RIGHT, Direction.LEFT)
    sign = 1.0 if direction in (Direction.RIGHT, Direction.DOWN) else -1.0
    return sign * (estimate.hs if level else estimate.vs)


def _ratio(value: float, number: int) -> float | None:
    return value / number if number else None
