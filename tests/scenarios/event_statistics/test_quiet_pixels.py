import numpy as np
import pytest

from flybench.events import Events, concatenate_events
from scenarios.event_statistics.pixel_history import PixelHistory
from scenarios.event_statistics.quiet_pixels import chance_share, quiet_pixels
from tests.scenarios.event_statistics.made_events import SIZE, edge_events, events_of, noise_events

SPAN_US = 2_000_000


def quiet_in(events: Events) -> np.ndarray:
    history = PixelHistory(**SIZE)
    history.add(events)
    return quiet_pixels(history.counts, history.after_neighbour, SPAN_US)


def sorted_by_time(*streams: Events) -> Events:
    return np.sort(concatenate_events(streams), order="t", kind="stable")


@pytest.mark.parametrize("rate_hz", [0.2, 2.0, 10.0, 16.0])
def test_independent_noise_is_quiet(rate_hz: float) -> None:
    shares = [quiet_in(noise_events(rate_hz, SPAN_US, seed)).mean() for seed in range(6)]
    assert np.mean(shares) > 0.9


@pytest.mark.parametrize("rate_hz", [0.0, 0.2, 2.0])
@pytest.mark.parametrize("events_each", [1, 8])
def test_a_moving_edge_is_not_quiet(rate_hz: float, events_each: int) -> None:
    edge = edge_events(px_s=300.0, events_each=events_each)
    assert not quiet_in(sorted_by_time(edge, noise_events(rate_hz, SPAN_US))).any()


def test_blocks_beside_a_signal_stay_quiet() -> None:
    edge = edge_events(px_s=300.0, events_each=5)
    quiet = quiet_in(edge[edge["x"] < 16])
    assert not quiet[:, :16].any()
    assert quiet[:, 16:].all()


def test_a_hot_pixel_is_noise() -> None:
    hot = events_of(*((t, 12, 12, 1) for t in range(0, SPAN_US, 20_000)))
    assert quiet_in(sorted_by_time(hot, noise_events(0.5, SPAN_US)))[12, 12]


def test_the_share_by_chance() -> None:
    assert chance_share(np.array([0.0])) == pytest.approx(0.5)
    assert chance_share(np.array([17.0, 500.0])) == pytest.approx(2 / 3, abs=0.01)


def test_the_last_blocks_of_a_sensor_may_be_smaller() -> None:
    counts = np.zeros((2, 9, 17), np.int64)
    assert quiet_pixels(counts, counts, SPAN_US).shape == (9, 17)
