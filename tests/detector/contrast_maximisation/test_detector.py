import numpy as np
import pytest

from detector.contrast_maximisation.detector import (
    ContrastConfig,
    ContrastEstimate,
    ContrastMaximisation,
    Reward,
    maximise_contrast,
)
from detector.errors import DetectorConfigError
from detector.estimate import FrameDetector, MotionEstimate
from flybench.direction import CARDINAL, Direction
from flybench.events import Events
from tests.detector.moving_dots import WINDOW_US, dots, texture
from tests.detector.stimuli import HEIGHT, WIDTH, hot_pixels, merged, noise
from tests.detector.test_operating_range import passing, share_with


def estimate_of(
    events: Events, *, start: tuple[float, float] | None = None, reward: Reward = Reward.GRADIENT
) -> ContrastEstimate:
    estimate = maximise_contrast(
        events,
        from_us=0,
        to_us=WINDOW_US,
        width=WIDTH,
        height=HEIGHT,
        config=ContrastConfig(reward=reward),
        start=start,
    )
    assert estimate is not None
    return estimate


def error_px_s(estimate: ContrastEstimate, truth: tuple[float, float]) -> float:
    return float(np.hypot(*np.subtract(estimate.velocity_px_s, truth)))


def velocity(speed_px_s: float, angle_deg: float) -> tuple[float, float]:
    angle = np.deg2rad(angle_deg)
    return float(speed_px_s * np.cos(angle)), float(speed_px_s * np.sin(angle))


@pytest.mark.parametrize("angle_deg", [17.0, -133.0])
@pytest.mark.parametrize("speed_px_s", [120.0, 290.0, 640.0, 1000.0])
def test_cold_and_warm_searches_find_the_velocity_of_dots_within_2_px_s(
    speed_px_s: float, angle_deg: float
) -> None:
    truth = velocity(speed_px_s, angle_deg)
    events = dots(truth, seed=int(speed_px_s))
    cold = estimate_of(events)
    warm = estimate_of(events, start=(0.93 * truth[0] + 15.0, 0.93 * truth[1] - 15.0))
    assert (cold.is_cold, warm.is_cold) == (True, False)
    assert error_px_s(cold, truth) < 2.0
    assert error_px_s(warm, truth) < 2.0


@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("speed_px_s", [120.0, 450.0, 1000.0])
def test_finds_the_velocity_of_textures_within_2_px_s(
    speed_px_s: float, direction: Direction
) -> None:
    events = texture(speed_px_s, direction, most=20_000)
    angle = direction.angle_deg
    assert angle is not None
    assert error_px_s(estimate_of(events), velocity(speed_px_s, angle)) < 2.0


@pytest.mark.parametrize("reward", Reward)
def test_every_reward_finds_the_velocity(reward: Reward) -> None:
    truth = velocity(430.0, 60.0)
    assert error_px_s(estimate_of(dots(truth), reward=reward), truth) < 3.0


def test_slow_oblique_motion_is_not_biased_towards_the_axes() -> None:
    truth = velocity(60.0, 20.0)
    assert error_px_s(estimate_of(dots(truth, seed=4)), truth) < 5.0


def test_a_wrong_start_does_not_change_the_velocity() -> None:
    truth = velocity(500.0, 0.0)
    assert error_px_s(estimate_of(dots(truth), start=velocity(900.0, 120.0)), truth) < 2.0


def test_a_warm_start_in_noise_ends_in_a_cold_search() -> None:
    events = noise(5.0, duration_us=WINDOW_US)
    assert estimate_of(events, start=(300.0, 0.0)).is_cold


def test_events_with_exchanged_times_are_not_prominent() -> None:
    events = dots(velocity(500.0, 0.0))
    assert estimate_of(events).prominence > 30.0
    rng = np.random.default_rng(0)
    events[["x", "y", "p"]] = rng.permutation(events[["x", "y", "p"]])
    assert estimate_of(events).prominence < 8.0


def test_too_few_events_give_no_estimate() -> None:
    few = dots(velocity(500.0, 0.0))[:49]
    assert maximise_contrast(few, from_us=0, to_us=WINDOW_US, width=WIDTH, height=HEIGHT) is None


def estimates_of(events: Events, until_us: int, config: ContrastConfig) -> list[MotionEstimate]:
    detector = ContrastMaximisation(config)
    return detector.push(events) + detector.advance(until_us)


@pytest.mark.parametrize(
    ("speed_px_s", "direction", "noise_hz"),
    [
        (130, Direction.UP, 10.0),
        (620, Direction.LEFT, 10.0),
        (620, Direction.LEFT, 0.0),
        (1400, Direction.DOWN, 10.0),
    ],
)
def test_the_detector_finds_the_direction_and_the_velocity(
    speed_px_s: int, direction: Direction, noise_hz: float
) -> None:
    events, until_us = passing(speed_px_s, direction, noise_hz=noise_hz)
    estimates = estimates_of(events, until_us, ContrastConfig(hop_us=50_000))[2:]
    assert share_with(estimates, direction) == 1.0
    angle = direction.angle_deg
    assert angle is not None
    middle = np.median([e.response for e in estimates], axis=0)
    assert np.hypot(*(middle - velocity(speed_px_s, angle))) < 3.0


@pytest.mark.parametrize("rate_hz", [0.1, 1.0, 5.0, 20.0])
def test_noise_and_hot_pixels_give_none(rate_hz: float) -> None:
    until_us = 300_000
    events = merged(
        noise(rate_hz, duration_us=until_us, seed=7),
        hot_pixels(20, 50, duration_us=until_us, seed=8),
    )
    estimates = estimates_of(events, until_us, ContrastConfig(hop_us=50_000))
    assert {e.direction for e in estimates} == {Direction.NONE}


def test_cuts_and_calls_of_advance_change_no_estimate() -> None:
    until_us = 300_000
    events, _ = passing(620, Direction.RIGHT, noise_hz=3.0)
    events = events[events["t"] < until_us]
    whole = estimates_of(events, until_us, ContrastConfig(hop_us=25_000))
    detector, pieces = ContrastMaximisation(ContrastConfig(hop_us=25_000)), []
    for start in range(0, events.size, 7001):
        piece = events[start : start + 7001]
        pieces += detector.push(piece) + detector.advance(int(piece["t"][-1]))
    assert pieces + detector.advance(until_us) == whole
    assert [e.t_us for e in whole] == list(range(25_000, until_us + 1, 25_000))


def test_it_is_not_a_frame_detector() -> None:
    assert not isinstance(ContrastMaximisation(), FrameDetector)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"limit_px_s": 0.0}, "limit_px_s is 0.0"),
        ({"hop_us": 20_000}, "Allowed is a multiple of hop_us"),
        ({"reward": "variance"}, "Reward.VARIANCE"),
    ],
)
def test_parameters_out_of_range_are_refused(values: dict[str, object], words: str) -> None:
    with pytest.raises(DetectorConfigError, match=words):
        ContrastConfig(**values)  # type: ignore[arg-type]
