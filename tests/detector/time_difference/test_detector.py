import pytest

from detector.errors import DetectorConfigError
from detector.estimate import FrameDetector
from detector.time_difference.detector import TimeDifference, TimeDifferenceConfig
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
@pytest.mark.parametrize("speed_px_s", [60, 300])
def test_the_direction_of_a_texture_is_right(speed_px_s: float, direction: Direction) -> None:
    assert share_right(TimeDifference, speed_px_s, direction, 1.0) >= 0.99


@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("speed_px_s", [60, 400, 1000])
def test_the_direction_of_a_bar_is_right(speed_px_s: float, direction: Direction) -> None:
    assert share_right_on_bar(TimeDifference, speed_px_s, direction) >= 0.95


@pytest.mark.parametrize("rate_hz", [0.1, 1.0, 5.0, 20.0])
def test_noise_gives_none(rate_hz: float) -> None:
    assert share_none_in_noise(TimeDifference, rate_hz) >= 0.99


def test_cuts_and_calls_of_advance_change_no_estimate() -> None:
    assert_cuts_change_nothing(TimeDifference)


def test_a_late_start_changes_nothing() -> None:
    assert_a_late_start_changes_nothing(TimeDifference)


def test_many_events_at_one_time_are_survived() -> None:
    assert_many_events_at_one_time_are_survived(TimeDifference)


def test_it_is_not_a_frame_detector() -> None:
    assert not isinstance(TimeDifference(), FrameDetector)


@pytest.mark.parametrize("values", [{"cell_px": 0}, {"weight_na": float("nan")}])
def test_parameters_out_of_range_are_refused(values: dict[str, object]) -> None:
    with pytest.raises(DetectorConfigError, match=next(iter(values))):
        TimeDifferenceConfig(**values)  # type: ignore[arg-type]


@pytest.mark.parametrize(("hop_us", "window_us"), [(20_000, 50_000), (1_500, 3_000)])
def test_a_hop_is_whole_steps_and_a_window_whole_hops(hop_us: int, window_us: int) -> None:
    with pytest.raises(DetectorConfigError, match="Allowed is a multiple of"):
        TimeDifferenceConfig(hop_us=hop_us, window_us=window_us)


def test_a_sensor_too_small_for_two_cells_is_refused() -> None:
    with pytest.raises(DetectorConfigError, match="Choose a smaller cell_px"):
        TimeDifference(width=3, height=40)
