"""Scores of estimates against a made-up track."""

import pytest

from detector.estimate import MotionEstimate
from detector.metrics import Box, Point
from flybench.direction import Direction
from scenarios.pipeline.scoring import TargetTrack, score_estimates

IN_VIEW_US = (100_000, 300_000)


def estimate(t_us: int, direction: Direction, roi: Box | None = (0, 0, 10, 10)) -> MotionEstimate:
    strength = 0.6 if direction is Direction.RIGHT else 0.5
    return MotionEstimate(t_us, 0.5, 0.0, direction, strength, (t_us * 1.0, 0.0), (5.0, 5.0), roi)


def track_of(box: Box | None, centroid: Point | None) -> TargetTrack:
    track = TargetTrack()
    track.add(0, None, None)
    track.add(IN_VIEW_US[0], box, centroid)
    track.add(IN_VIEW_US[1], box, centroid)
    track.add(IN_VIEW_US[1] + 1, None, None)
    return track


ESTIMATES = [
    estimate(50_000, Direction.DOWN),  # before the target is in view
    estimate(150_000, Direction.LEFT),
    estimate(200_000, Direction.RIGHT),
    estimate(225_000, Direction.RIGHT),
    estimate(250_000, Direction.LEFT),
    estimate(260_000, Direction.UP),
    estimate(300_000, Direction.NONE, None),
    estimate(310_000, Direction.DOWN),  # after the target has left
]


def test_only_estimates_in_view_are_scored() -> None:
    found = score_estimates(ESTIMATES, "right", IN_VIEW_US, track_of((0, 0, 10, 20), (5.0, 8.0)))
    assert found["direction"] == "right"
    assert found["accuracy"] == pytest.approx(2 / 6)
    assert found["steps_in_view"] == 6
    assert found["latency_ms"] == 100


def test_a_target_in_view_from_the_start_has_no_latency() -> None:
    track = track_of((0, 0, 10, 20), (5.0, 8.0))
    found = score_estimates(ESTIMATES, "right", (0, 300_000), track)
    assert found["latency_ms"] is None
    assert found["accuracy"] == pytest.approx(2 / 7)
    assert score_estimates(ESTIMATES, "right", (1_000, 300_000), track)["latency_ms"] == 199


def test_errors_after_100_ms_are_counted_by_kind() -> None:
    found = score_estimates(ESTIMATES, "right", IN_VIEW_US, track_of((0, 0, 10, 20), (5.0, 8.0)))
    kinds = ("accuracy", "opposite", "sideways", "none")
    shares = [found[f"{kind}_after_100ms"] for kind in kinds]
    assert shares == pytest.approx([1 / 4] * 4)


def test_region_and_view_centre_are_compared_with_box_and_centroid() -> None:
    found = score_estimates(ESTIMATES, "right", IN_VIEW_US, track_of((0, 0, 10, 20), (5.0, 8.0)))
    assert found["roi_iou"] == pytest.approx(3 / 4 * 0.5)  # one step without a region
    assert found["centroid_error_px"] == pytest.approx(3.0)


def test_a_detector_without_any_region_has_no_overlap() -> None:
    estimates = [estimate(t_us, Direction.RIGHT, None) for t_us in (220_000, 250_000)]
    track = track_of((0, 0, 10, 20), (5.0, 8.0))
    found = score_estimates(estimates, "right", IN_VIEW_US, track)
    assert found["roi_iou"] is None
    assert found["centroid_error_px"] == pytest.approx(3.0)
    before = estimate(50_000, Direction.NONE)
    assert score_estimates([before, *estimates], "right", IN_VIEW_US, track)["roi_iou"] == 0.0


def test_the_true_direction_may_be_a_string() -> None:
    track = track_of((0, 0, 1, 1), (0.5, 0.5))
    by_enum = score_estimates(ESTIMATES, Direction.LEFT, IN_VIEW_US, track)
    assert by_enum == score_estimates(ESTIMATES, "left", IN_VIEW_US, track)
    assert by_enum["accuracy"] == pytest.approx(2 / 6)


def test_without_estimates_there_are_no_scores() -> None:
    found = score_estimates([], "up", (0, 0), TargetTrack())
    assert found["direction"] == "none"
    assert found["steps_in_view"] == 0
    nothing = {name for name, value in found.items() if value is None}
    assert nothing >= {"accuracy", "opposite_after_100ms", "roi_iou", "centroid_error_px", "grms"}


def test_a_track_holds_each_sample_until_the_next() -> None:
    track = track_of((1, 2, 3, 4), (2.0, 3.0))
    assert track.in_view_us == IN_VIEW_US
    assert track.box_px(-1) is None
    assert track.box_px(99_999) is None
    assert track.box_px(100_000) == track.box_px(200_000) == (1, 2, 3, 4)
    assert track.centroid_px(200_000) == (2.0, 3.0)
    assert track.box_px(400_000) is None
    assert TargetTrack().in_view_us == (0, 0)
