"""Filters of events, against their definitions in plain Python."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from detector import DetectorConfigError
from detector.denoise import (
    FILTERS,
    BackgroundActivityFilter,
    DoubleWindowFilter,
    SpatioTemporalFilter,
    TimeSurfaceFilter,
)
from flybench.events import EVENT_DTYPE, Events

WIDTH, HEIGHT = 6, 5
Event = tuple[int, int, int, bool]


@st.composite
def streams(draw: st.DrawFn) -> Events:
    one = st.tuples(
        st.integers(0, 60_000),
        st.integers(0, WIDTH - 1),
        st.integers(0, HEIGHT - 1),
        st.booleans(),
    )
    return np.array(sorted(draw(st.lists(one, max_size=40))), EVENT_DTYPE)


def before(events: Events, n: int) -> list[Event]:
    return [event.item() for event in events[:n]]


def is_neighbour(a: Event, b: Event) -> bool:
    return max(abs(a[1] - b[1]), abs(a[2] - b[2])) == 1


@given(streams())
def test_background_activity_scores_are_minus_the_age_of_the_latest_neighbour(
    events: Events,
) -> None:
    scores = BackgroundActivityFilter(width=WIDTH, height=HEIGHT).scores(events)
    for n, score in enumerate(scores):
        event = events[n].item()
        times = [other[0] for other in before(events, n) if is_neighbour(event, other)]
        assert score == (max(times) - event[0] if times else -math.inf)


@given(streams(), st.integers(1, 3))
def test_spatio_temporal_scores_are_those_of_the_kth_latest_neighbour(
    events: Events, k: int
) -> None:
    scores = SpatioTemporalFilter(width=WIDTH, height=HEIGHT, supporters=k).scores(events)
    for n, score in enumerate(scores):
        event = events[n].item()
        latest: dict[tuple[int, int], int] = {}
        for other in before(events, n):
            if is_neighbour(event, other) and other[3] == event[3]:
                latest[other[1:3]] = other[0]
        times = sorted(latest.values(), reverse=True)
        assert score == (times[k - 1] - event[0] if len(times) >= k else -math.inf)


@given(streams(), st.integers(1, 2))
def test_time_surface_scores_are_the_mean_surface_of_the_neighbourhood(
    events: Events, radius: int
) -> None:
    made = TimeSurfaceFilter(width=WIDTH, height=HEIGHT, radius_px=radius)
    for n, score in enumerate(made.scores(events)):
        event = events[n].item()
        latest: dict[tuple[int, int], int] = {}
        for other in before(events, n):
            distance = max(abs(event[1] - other[1]), abs(event[2] - other[2]))
            if distance <= radius and other[3] == event[3]:
                latest[other[1:3]] = other[0]
        total = sum(math.exp((t - event[0]) / 20_000) for t in latest.values())
        assert score == pytest.approx(total / (2 * radius + 1) ** 2, abs=1e-6)


@given(streams(), st.integers(1, 2), st.integers(0, 4))
def test_double_window_scores_are_the_distance_of_the_kth_nearest_of_both_windows(
    events: Events, k: int, sigma_px: int
) -> None:
    made = DoubleWindowFilter(width=WIDTH, height=HEIGHT, length=8, sigma_px=sigma_px, supporters=k)
    signal: list[Event] = []
    noise: list[Event] = []
    for n, score in enumerate(made.scores(events)):
        event = events[n].item()
        distances = sorted(
            abs(event[1] - other[1]) + abs(event[2] - other[2])
            for other in signal[-4:] + noise[-4:]
        )
        assert score == (-distances[k - 1] if len(distances) >= k else -math.inf)
        (signal if score >= -sigma_px else noise).append(event)


@pytest.mark.parametrize("name", FILTERS)
@given(streams(), st.lists(st.integers(0, 40), max_size=4))
@settings(max_examples=20)
def test_cuts_between_chunks_change_nothing(name: str, events: Events, cuts: list[int]) -> None:
    make = partial(FILTERS[name], width=WIDTH, height=HEIGHT)
    whole, cut = make(), make()
    parts = np.split(events, sorted(cuts))
    scores = np.concatenate([cut.scores(part) for part in parts])
    assert (scores == whole.scores(events)).all()
    kept = make().keep(events)
    assert (kept == events[scores >= whole.threshold]).all()


def edge_and_noise() -> tuple[Events, np.ndarray]:
    """A vertical edge that crosses 346×260 px at 1000 px/s, and noise of 1 Hz per pixel."""
    random = np.random.default_rng(0)
    edge, noise = np.zeros(346 * 260, EVENT_DTYPE), np.zeros(346 * 90, EVENT_DTYPE)
    column, edge["y"] = np.repeat(np.arange(346), 260), np.tile(np.arange(260), 346)
    edge["x"], edge["p"] = column, True
    edge["t"] = column * 1000 + random.integers(0, 500, edge.size)
    noise["t"], noise["p"] = (
        random.integers(0, 346_000, noise.size),
        random.random(noise.size) < 0.5,
    )
    noise["x"], noise["y"] = (random.integers(0, side, noise.size) for side in (346, 260))
    events = np.concatenate([edge, noise])
    order = np.argsort(events["t"], kind="stable")
    return events[order], order < edge.size


@pytest.mark.parametrize("name", FILTERS)
def test_a_filter_keeps_most_of_an_edge_and_little_noise(name: str) -> None:
    events, is_signal = edge_and_noise()
    made = FILTERS[name](width=346, height=260)
    kept = made.scores(events) >= made.threshold
    signal, noise = kept[is_signal].mean(), kept[~is_signal].mean()
    assert signal > 0.9
    assert noise < 0.5


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (partial(BackgroundActivityFilter, tau_us=0), r"tau_us is 0\. Allowed is a whole number"),
        (partial(SpatioTemporalFilter, supporters=9), r"supporters is 9\. Allowed .* 1 to 8"),
        (partial(TimeSurfaceFilter, threshold=1.5), r"threshold is 1\.5\. Allowed .* 0 to 1"),
        (partial(DoubleWindowFilter, length=1), r"length is 1\. Allowed is a whole number from 2"),
        (partial(DoubleWindowFilter, sigma_px=-1), r"sigma_px is -1\."),
    ],
)
def test_a_parameter_out_of_range_is_refused(make: Callable[..., object], message: str) -> None:
    with pytest.raises(DetectorConfigError, match=message):
        make(width=8, height=8)
    with pytest.raises(DetectorConfigError, match=r"width is 0\. Allowed is"):
        BackgroundActivityFilter(width=0, height=8)
