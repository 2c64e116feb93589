import pytest
from hypothesis import given
from hypothesis import strategies as st

from detector.decision import clip_to_open_interval, velocity_estimate, winner_take_all
from flybench.direction import Direction


@given(st.floats(allow_nan=False))
def test_clipped_values_stay_inside_the_open_interval(value: float) -> None:
    assert -1.0 < clip_to_open_interval(value) < 1.0


def test_values_inside_the_interval_are_not_changed() -> None:
    assert clip_to_open_interval(-0.25) == -0.25


@pytest.mark.parametrize(("ratio", "expected"), [(5.0, Direction.UP), (4.9, Direction.NONE)])
def test_a_velocity_gives_a_direction_if_it_exceeds_the_floor(
    ratio: float, expected: Direction
) -> None:
    estimate = velocity_estimate(
        10_000,
        (300.0, -600.0),
        limit_px_s=1500.0,
        ratio=ratio,
        ratio_floor=5.0,
        image_centre_px=(173.0, 130.0),
    )
    assert (estimate.hs, estimate.vs, estimate.strength) == (0.2, -0.4, 0.4)
    assert (estimate.direction, estimate.response) == (expected, (300.0, -600.0))
    assert (estimate.view_centre_px, estimate.roi_px) == ((173.0, 130.0), None)


@pytest.mark.parametrize(
    ("hs", "vs", "snr", "expected"),
    [
        (0.5, 0.4, (9.0, 9.0), Direction.RIGHT),
        (-0.5, 0.4, (9.0, 9.0), Direction.LEFT),
        (0.3, 0.4, (9.0, 9.0), Direction.DOWN),
        (0.3, -0.4, (9.0, 9.0), Direction.UP),
        (0.2, 0.2, (9.0, 9.0), Direction.RIGHT),
        (1e-6, 0.0, (9.0, 0.0), Direction.RIGHT),
        (0.5, 0.4, (2.9, 9.0), Direction.NONE),
        (0.4, 0.5, (9.0, 2.9), Direction.NONE),
        (0.0, 0.0, (0.0, 0.0), Direction.NONE),
    ],
)
def test_the_stronger_system_wins_if_it_exceeds_the_floor(
    hs: float, vs: float, snr: tuple[float, float], expected: Direction
) -> None:
    assert winner_take_all(hs, vs, snr=snr, snr_floor=3.0) is expected


@pytest.mark.parametrize(
    ("shares", "expected"),
    [
        ((0.03, 0.0), Direction.LEFT),
        ((-0.03, 0.0), Direction.LEFT),
        ((0.029, 1.0), Direction.NONE),
    ],
)
def test_a_share_below_its_floor_gives_none(
    shares: tuple[float, float], expected: Direction
) -> None:
    found = winner_take_all(
        -0.5, 0.4, snr=(9.0, 9.0), snr_floor=3.0, shares=shares, share_floor=0.03
    )
    assert found is expected


def test_a_response_of_zero_gives_none_without_a_floor() -> None:
    assert winner_take_all(0.0, 0.0, snr=(0.0, 0.0), snr_floor=0.0) is Direction.NONE
