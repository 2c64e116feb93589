from dataclasses import replace

import numpy as np
import pytest

from detector.estimate import MotionEstimate
from flybench.direction import Direction
from scenarios.study.results import MethodRun, SequenceResult
from scenarios.study.rows import COLUMNS, response, study_rows


def estimate(
    t_us: int, hs: float, *, roi: tuple[int, int, int, int] | None = None
) -> MotionEstimate:
    direction = Direction.RIGHT if hs > 0 else Direction.LEFT
    return MotionEstimate(t_us, hs, 0.0, direction, abs(hs), (hs, 0.0), (5.0, 5.0), roi)


SCORES = {
    "direction": "right",
    "accuracy": 0.9,
    "accuracy_after_100ms": 1.0,
    "opposite_after_100ms": 0.0,
    "sideways_after_100ms": 0.0,
    "none_after_100ms": 0.0,
    "steps_in_view": 3,
    "latency_ms": 10.0,
    "roi_iou": 0.3,
    "centroid_error_px": 40.0,
    "grms": 2.0,
}
RUN = MethodRun(
    "fly",
    4,
    tuple(estimate(t, hs) for t, hs in ((150_000, 0.2), (260_000, 0.4))),
    SCORES,
    None,
    0.5,
    1000,
)
SEQUENCE = SequenceResult(
    lighting="day",
    omega_rad_s=1.61,
    speed_km_h=40.0,
    duration_us=500_000,
    in_view_us=(100_000, 400_000),
    velocity_t_us=np.array([0, 10_000]),
    velocity_px_s=np.array([-20.0, 522.0]),
    snapshots=(),
    runs=(RUN,),
)


def test_a_row_has_every_column_in_order() -> None:
    (row,) = study_rows([SEQUENCE])
    assert tuple(row) == COLUMNS
    assert (row["sequence"], row["method"], row["seed"]) == ("day_1.61", "fly", 4)
    assert (row["verdict"], row["truth"], row["duration_s"]) == ("right", "right", 0.5)
    assert row["image_speed_px_s"] == 522.0
    assert row["ms_per_estimate"] == pytest.approx(250.0)
    assert row["ns_per_event"] == pytest.approx(0.5e6)


def test_a_method_without_a_region_of_interest_has_no_overlap() -> None:
    (row,) = study_rows([SEQUENCE])
    assert (row["roi_iou"], row["centroid_error_px"]) == (None, None)
    attending = replace(RUN, estimates=(estimate(260_000, 0.4, roi=(0, 0, 9, 9)),))
    (row,) = study_rows([replace(SEQUENCE, runs=(attending,))])
    assert (row["roi_iou"], row["centroid_error_px"]) == (0.3, 40.0)


def test_without_estimates_there_is_no_time_per_estimate() -> None:
    (row,) = study_rows([replace(SEQUENCE, runs=(replace(RUN, estimates=(), events=0),))])
    assert (row["ms_per_estimate"], row["ns_per_event"]) == (None, None)
    assert (row["response_mean"], row["response_variation"]) == (None, None)


def test_the_response_is_that_of_settled_steps_along_the_true_direction() -> None:
    steps = ((150_000, 9.0), (250_000, 0.2), (300_000, 0.4), (390_000, 0.6))
    run = replace(RUN, estimates=tuple(estimate(t, hs) for t, hs in steps))
    mean, variation = response(SEQUENCE, run)
    assert mean == pytest.approx(0.4)
    assert variation == pytest.approx(0.5)
    mean, variation = response(replace(SEQUENCE, direction="left"), run)
    assert mean == pytest.approx(-0.4)
    assert variation is None
