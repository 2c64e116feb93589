import numpy as np
import pytest

from detector.errors import DetectorConfigError
from detector.estimate import FrameDetector
from detector.spiking_delays.detector import SpikingDelays, SpikingDelaysConfig, mean_velocity
from flybench.direction import CARDINAL, Direction
from tests.detector.drawn_trials import (
    assert_a_late_start_changes_nothing,
    assert_cuts_change_nothing,
    assert_many_events_at_one_time_are_survived,
    settled,
    share_none_in_noise,
    share_right,
    share_right_on_bar,
)
from tests.detector.test_operating_range import passing


def test_the_mean_velocity_is_that_of_the_spikes() -> None:
    spikes = np.zeros((8, 8), np.int64)
    spikes[2, 1] = spikes[2, 7] = 50  # 200 px/s, 45° above and below the way to the right
    (vx, vy), ratio = mean_velocity(spikes, 100.0)
    assert (vx, vy) == pytest.approx((200.0 / np.sqrt(2.0), 0.0))
    assert ratio == pytest.approx(10.0)  # √100: all spikes agree


def test_opposite_spikes_cancel() -> None:
    spikes = np.zeros((8, 8), np.int64)
    spikes[0, 0] = spikes[0, 4] = 50
    velocity, ratio = mean_velocity(spikes, 100.0)
    assert velocity == pytest.approx((0.0, 0.0))
    assert ratio == 0.0


@pytest.mark.parametrize("direction", [Direction.RIGHT, Direction.UP])
def test_the_direction_of_a_texture_is_right(direction: Direction) -> None:
    assert share_right(SpikingDelays, 200, direction, 0.0) >= 0.99


@pytest.mark.parametrize("speed_px_s", [60, 400])
@pytest.mark.parametrize("direction", CARDINAL)
def test_the_direction_of_a_bar_is_right(speed_px_s: int, direction: Direction) -> None:
    assert share_right_on_bar(SpikingDelays, speed_px_s, direction) >= 0.9


@pytest.mark.parametrize("speed_px_s", [60, 200])
def test_the_speed_is_right_to_a_factor_of_root_2(speed_px_s: float) -> None:
    events, _ = passing(speed_px_s, Direction.RIGHT, noise_hz=0.0)
    events = events[events["t"] < 200_000]
    found = settled(SpikingDelays(), events, 200_000)
    speed = float(np.median([np.hypot(*e.response) for e in found]))
    assert speed_px_s / np.sqrt(2.0) < speed < speed_px_s * np.sqrt(2.0)


@pytest.mark.parametrize("rate_hz", [0.1, 3.0])
def test_noise_gives_none(rate_hz: float) -> None:
    assert share_none_in_noise(SpikingDelays, rate_hz) >= 0.99


def test_cuts_and_calls_of_advance_change_no_estimate() -> None:
    assert_cuts_change_nothing(SpikingDelays)


def test_a_late_start_changes_nothing() -> None:
    assert_a_late_start_changes_nothing(SpikingDelays)


def test_many_events_at_one_time_are_survived() -> None:
    assert_many_events_at_one_time_are_survived(SpikingDelays)


def test_it_is_not_a_frame_detector() -> None:
    assert not isinstance(SpikingDelays(), FrameDetector)


def test_the_memory_covers_the_longest_delay() -> None:
    assert SpikingDelays().memory_us == 150_000  # √2 · 2 px at 28.3 px/s is 100 ms


@pytest.mark.parametrize("values", [{"slowest_px_s": 0.0}, {"snr_floor": float("nan")}])
def test_parameters_out_of_range_are_refused(values: dict[str, object]) -> None:
    with pytest.raises(DetectorConfigError, match=next(iter(values))):
        SpikingDelaysConfig(**values)  # type: ignore[arg-type]


def test_a_window_must_be_a_multiple_of_the_hop() -> None:
    with pytest.raises(DetectorConfigError, match="Allowed is a multiple of hop_us"):
        SpikingDelaysConfig(hop_us=20_000)
