import numpy as np
import pytest

from flybench.events import Events, concatenate_events
from scenarios.event_statistics.quiet_pixels import BIN_US, SimultaneousPairs, most_pairs
from tests.scenarios.event_statistics.made_events import SIZE, edge_events, events_of, noise_events

SPAN_US = 2_000_000


def quiet_in(events: Events) -> np.ndarray:
    pairs = SimultaneousPairs(**SIZE)
    for block in np.array_split(events, 3):
        pairs.add(block)
    return pairs.quiet_pixels(SPAN_US)


def sorted_by_time(*streams: Events) -> Events:
    return np.sort(concatenate_events(streams), order="t", kind="stable")


@pytest.mark.parametrize("rate_hz", [0.1, 2.0, 20.0])
def test_independent_noise_is_quiet(rate_hz: float) -> None:
    shares = [quiet_in(noise_events(rate_hz, SPAN_US, seed)).mean() for seed in range(6)]
    assert np.mean(shares) > 0.9


@pytest.mark.parametrize("rate_hz", [0.0, 0.2, 2.0])
@pytest.mark.parametrize("events_each", [1, 8])
def test_a_moving_edge_is_not_quiet(rate_hz: float, events_each: int) -> None:
    edge = edge_events(px_s=300.0, events_each=events_each)
    assert not quiet_in(sorted_by_time(edge, noise_events(rate_hz, SPAN_US))).any()


def test_blocks_beside_a_signal_are_not_quiet_but_those_farther_away_are() -> None:
    edge = edge_events(px_s=300.0, events_each=5)
    quiet = quiet_in(edge[edge["x"] < 8])
    assert not quiet[:, :16].any()
    assert quiet[:, 16:].all()


def test_a_hot_pixel_is_noise() -> None:
    hot = events_of(*((t, 12, 12, 1) for t in range(0, SPAN_US, 20_000)))
    assert quiet_in(sorted_by_time(hot, noise_events(0.5, SPAN_US)))[12, 12]


def flicker(rate_hz: float) -> Events:
    """Noise of this rate that lamps at 100 Hz confine to 3 ms of each period."""
    events = noise_events(rate_hz, SPAN_US)
    events["t"] = events["t"] // 10_000 * 10_000 + events["t"] % 3000
    return np.sort(events, order="t", kind="stable")


@pytest.mark.parametrize("rate_hz", [3.0, 15.0])
def test_the_flicker_of_lamps_is_not_quiet(rate_hz: float) -> None:
    assert not quiet_in(flicker(rate_hz)).any()


def test_the_bursts_of_one_pixel_are_no_pairs() -> None:
    rows = [(t + k, 12, 12, 1) for t in range(0, SPAN_US, 100_000) for k in range(50)]
    assert quiet_in(events_of(*rows)).all()


def test_pairs_by_chance() -> None:
    limit = most_pairs(np.array([0, 100]), 50.0)
    assert limit.tolist() == [1.0, 1.25 * 100 + 3 * 10 + 1]


def test_the_last_blocks_of_a_sensor_may_be_smaller() -> None:
    pairs = SimultaneousPairs(width=17, height=9)
    pairs.add(events_of((0, 16, 8, 1), (1, 16, 7, 1), (2, 15, 8, 1), (BIN_US, 16, 8, 1)))
    quiet = pairs.quiet_pixels(SPAN_US)
    assert quiet.shape == (9, 17)
    assert quiet.all()
