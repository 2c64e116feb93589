import pytest

from detector.errors import DetectorConfigError
from detector.estimate import FrameDetector
from detector.space_time_filters.detector import SpaceTimeFilters, SpaceTimeFiltersConfig
from flybench.direction import CARDINAL, Direction
from tests.detector.drawn_trials import (
    assert_a_late_start_changes_nothing,
    assert_cuts_change_nothing,
    assert_many_events_at_one_time_are_survived,
    share_none_in_noise,
    share_right,
    share_right_on_bar,
)


@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("speed_px_s", [100, 300])
def test_the_direction_of_a_texture_is_right(speed_px_s: float, direction: Direction) -> None:
    assert share_right(SpaceTimeFilters, speed_px_s, direction, 1.0) >= 0.99


@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("speed_px_s", [200, 400, 1000])
def test_the_direction_of_a_bar_is_right(speed_px_s: float, direction: Direction) -> None:
    assert share_right_on_bar(SpaceTimeFilters, speed_px_s, direction) >= 0.95


@pytest.mark.parametrize("rate_hz", [0.1, 1.0, 5.0, 20.0])
def test_noise_gives_none(rate_hz: float) -> None:
    assert share_none_in_noise(SpaceTimeFilters, rate_hz) >= 0.99


def test_cuts_and_calls_of_advance_change_no_estimate() -> None:
    assert_cuts_change_nothing(SpaceTimeFilters)


def test_a_late_start_changes_nothing() -> None:
    assert_a_late_start_changes_nothing(SpaceTimeFilters)


def test_many_events_at_one_time_are_survived() -> None:
    assert_many_events_at_one_time_are_survived(SpaceTimeFilters)


def test_it_is_not_a_frame_detector() -> None:
    assert not isinstance(SpaceTimeFilters(), FrameDetector)


@pytest.mark.parametrize("values", [{"slowest_px_s": 0.0}, {"alpha_q": float("nan")}])
def test_parameters_out_of_range_are_refused(values: dict[str, object]) -> None:
    with pytest.raises(DetectorConfigError, match=next(iter(values))):
        SpaceTimeFiltersConfig(**values)  # type: ignore[arg-type]


def test_a_window_must_be_a_multiple_of_the_hop() -> None:
    with pytest.raises(DetectorConfigError, match="Allowed is a multiple of hop_us"):
        SpaceTimeFiltersConfig(hop_us=20_000)


def test_a_sensor_smaller_than_a_cell_is_refused() -> None:
    with pytest.raises(DetectorConfigError, match="Use a larger sensor"):
        SpaceTimeFilters(width=1, height=40)


def test_the_memory_covers_the_slowest_filter() -> None:
    # 3.5 μ_bi1 of the filter for 50 px/s, and the window
    assert SpaceTimeFilters().memory_us == pytest.approx(50_000 + 3.5 * 49_000, rel=0.01)
