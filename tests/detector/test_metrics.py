import math

import pytest

from detector.errors import DetectorError
from detector.estimate import MotionEstimate
from detector.fly.model_variants import GrmsResponse
from detector.metrics import (
    Box,
    accuracy,
    centroid_error_px,
    grms,
    intersection_over_union,
    onset_latency_us,
    verdict,
    within,
)
from flybench.direction import Direction

CROSSING = (10_000, 50_000)


def estimate(
    t_us: int,
    direction: Direction,
    *,
    strength: float = 0.5,
    response: tuple[float, float] = (0.0, 0.0),
) -> MotionEstimate:
    return MotionEstimate(
        t_us=t_us,
        hs=0.0,
        vs=0.0,
        direction=direction,
        strength=strength,
        response=response,
        view_centre_px=(0.0, 0.0),
        roi_px=None,
    )


STEPS = [
    estimate(10_000, Direction.LEFT),
    estimate(20_000, Direction.NONE),
    estimate(30_000, Direction.RIGHT, strength=0.9),
    estimate(40_000, Direction.UP, strength=0.3),
    estimate(50_000, Direction.UP, strength=0.4),
    estimate(60_000, Direction.LEFT),
]


def test_a_crossing_is_open_at_its_start_and_closed_at_its_end() -> None:
    assert [e.t_us for e in within(STEPS, CROSSING)] == [20_000, 30_000, 40_000, 50_000]


def test_accuracy_counts_none_as_wrong() -> None:
    assert accuracy(STEPS, Direction.UP, crossing_us=CROSSING) == 0.5
    assert accuracy(STEPS, Direction.RIGHT, crossing_us=CROSSING) == 0.25


def test_accuracy_without_steps_is_none() -> None:
    assert accuracy(STEPS, Direction.UP, crossing_us=(70_000, 80_000)) is None


def test_the_verdict_weighs_steps_by_strength() -> None:
    assert verdict(STEPS, crossing_us=CROSSING) is Direction.RIGHT


def test_the_verdict_without_a_direction_is_none() -> None:
    assert verdict(STEPS[1:2], crossing_us=CROSSING) is Direction.NONE


def test_latency_is_measured_from_entry() -> None:
    assert onset_latency_us(STEPS, Direction.UP, crossing_us=CROSSING) == 30_000
    assert onset_latency_us(STEPS, Direction.DOWN, crossing_us=CROSSING) is None


def steps_with_responses(*responses: tuple[float, float]) -> list[MotionEstimate]:
    """Return steps every 10 ms, the first at 20 ms."""
    return [
        estimate(20_000 + 10_000 * n, Direction.UP, response=r) for n, r in enumerate(responses)
    ]


def test_grms_is_the_rms_slope_of_the_stronger_system() -> None:
    steps = steps_with_responses((0.0, 0.0), (5.0, 4.0), (5.0, -12.0), (-6.0, 3.0))
    squares = 500.0**2, (5.0**2 + 12.0**2) * 100.0**2, (12.0**2 + 6.0**2) * 100.0**2
    found = grms(steps, crossing_us=CROSSING, step_us=10_000)
    assert found == pytest.approx(math.sqrt(sum(squares) / 3))


def test_grms_of_both_systems_includes_the_weaker_one() -> None:
    steps = steps_with_responses((0.0, 0.0), (4.0, 3.0), (4.0, 3.0))
    both = grms(steps, crossing_us=CROSSING, of=GrmsResponse.BOTH, step_us=10_000)
    assert both == pytest.approx(math.sqrt((500.0**2 + 0.0) / 2))


def test_a_gradient_spans_at_least_step_us() -> None:
    steps = steps_with_responses((0.0, 0.0), (9.0, 0.0), (1.0, 0.0))
    assert grms(steps, crossing_us=CROSSING, step_us=20_000) == pytest.approx(50.0)
    assert grms(steps, crossing_us=CROSSING, step_us=15_000) == pytest.approx(50.0)
    assert grms(steps, crossing_us=CROSSING, step_us=1) == grms(
        steps, crossing_us=CROSSING, step_us=10_000
    )


def test_grms_needs_two_steps_that_are_step_us_apart() -> None:
    assert grms(STEPS[:2], crossing_us=CROSSING, step_us=10_000) is None
    assert grms(STEPS, crossing_us=CROSSING) is None


@pytest.mark.parametrize("second_us", [30_000, 20_000])
def test_grms_refuses_steps_out_of_order(second_us: int) -> None:
    steps = [estimate(30_000, Direction.UP), estimate(second_us, Direction.UP)]
    with pytest.raises(DetectorError, match=f"at {second_us} µs follows one at 30000 µs"):
        grms(steps, crossing_us=CROSSING)


@pytest.mark.parametrize(
    ("other", "overlap"),
    [
        ((0, 0, 10, 10), 1.0),
        ((5, 0, 15, 10), 50 / 150),
        ((2, 2, 4, 12), 16 / 104),
        ((10, 0, 20, 10), 0.0),
        ((20, 20, 30, 30), 0.0),
        (None, 0.0),
    ],
)
def test_overlap_of_boxes(other: Box | None, overlap: float) -> None:
    box = (0, 0, 10, 10)
    assert intersection_over_union(box, other) == intersection_over_union(other, box)
    assert intersection_over_union(box, other) == pytest.approx(overlap)


def test_boxes_without_area_do_not_overlap() -> None:
    assert intersection_over_union((3, 3, 3, 3), (3, 3, 3, 3)) == 0.0


def test_the_centroid_error_is_a_distance() -> None:
    assert centroid_error_px((10.0, 20.0), (13.0, 24.0)) == 5.0
