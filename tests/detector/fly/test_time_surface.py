import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from detector.fly.config import FlyConfig
from detector.fly.model_variants import Averaging, SurfaceEvents
from detector.fly.time_surface import TimeSurfaces
from flybench.events import EVENT_DTYPE, Events

WIDTH, HEIGHT = 20, 15


def events_of(rows: list[tuple[int, int, int, bool]]) -> Events:
    return np.array(sorted(rows, key=lambda row: row[0]), EVENT_DTYPE)


def reference_surfaces(events: Events, c: FlyConfig, end_us: int) -> npt.NDArray[np.float64]:
    """Compute equations 2 to 8 event by event."""
    sums = np.zeros((2, -(-HEIGHT // c.cell_px), -(-WIDTH // c.cell_px)))
    counts = np.zeros_like(sums)
    for t, x, y, p in events.tolist():
        if not end_us - c.window_us <= t < end_us:
            continue
        surface = sum(
            math.exp(-(t - tj) / c.tau_us)
            for tj, xj, yj, pj in events.tolist()
            if pj == p
            and abs(xj - x) <= c.neighbourhood_px
            and abs(yj - y) <= c.neighbourhood_px
            and t - c.window_us <= tj < t
        )
        sums[int(p), y // c.cell_px, x // c.cell_px] += surface
        counts[int(p), y // c.cell_px, x // c.cell_px] += 1
    divisors: dict[Averaging, npt.NDArray[np.float64]] = {
        Averaging.EVENTS: np.maximum(counts, 1),
        Averaging.BOTH: np.broadcast_to(np.maximum(counts.sum(axis=0), 1), counts.shape),
        Averaging.AREA: np.full_like(counts, c.cell_px**2),
        Averaging.NONE: np.ones_like(counts),
    }
    return np.asarray(sums / divisors[c.averaging], np.float64)


def surfaces_at(events: Events, c: FlyConfig, end_us: int) -> npt.NDArray[np.float32]:
    surfaces = TimeSurfaces(c, width=WIDTH, height=HEIGHT)
    taken = 0
    for hop in range(end_us // c.hop_us):
        surfaces.begin_hop(hop)
        until_us = (hop + 1) * c.hop_us
        taken = surfaces.accumulate(events, taken, until_us=until_us)
    return surfaces.average(hop=end_us // c.hop_us - 1)


# Few pixels and few distinct times, so that repeats, ties and expiry all occur.
crowded = st.lists(
    st.tuples(
        st.integers(0, 60).map(lambda n: n * 2_500),
        st.integers(3, 6),
        st.integers(2, 4),
        st.booleans(),
    ),
    max_size=80,
).map(events_of)


@pytest.mark.parametrize("averaging", list(Averaging))
@pytest.mark.parametrize("neighbourhood_px", [0, 1])
@settings(max_examples=30, deadline=None)
@given(events=crowded)
def test_agrees_with_the_equations(
    averaging: Averaging, neighbourhood_px: int, events: Events
) -> None:
    config = FlyConfig(averaging=averaging, neighbourhood_px=neighbourhood_px)
    for end_us in (100_000, 160_000):
        expected = reference_surfaces(events, config, end_us)
        np.testing.assert_allclose(surfaces_at(events, config, end_us), expected, rtol=1e-6)


def test_an_isolated_event_scores_exactly_zero_after_a_busy_past() -> None:
    busy = [(t, 4, 4, True) for t in range(0, 30_000, 7)]
    alone = [(115_000, 4, 4, True)]
    assert surfaces_at(events_of(busy + alone), FlyConfig(), 50_000)[1, 1, 1] > 1000.0
    assert surfaces_at(events_of(busy + alone), FlyConfig(), 120_000)[1, 1, 1] == 0.0


def test_events_of_one_microsecond_do_not_affect_each_other() -> None:
    twins = events_of([(5, 4, 4, True), (5, 4, 4, True)])
    assert surfaces_at(twins, FlyConfig(averaging=Averaging.NONE), 50_000).max() == 0.0


def test_an_event_may_count_in_its_own_surface() -> None:
    config = FlyConfig(time_surface=SurfaceEvents.ITSELF, averaging=Averaging.NONE)
    alone = events_of([(115_000, 4, 4, True)])
    assert surfaces_at(alone, config, 120_000)[1, 1, 1] == 1.0
    pair = events_of([(100_000, 4, 4, True), (115_000, 4, 4, True)])
    expected = 2.0 + math.exp(-15 / 30)
    assert surfaces_at(pair, config, 120_000)[1, 1, 1] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("tau_us", [500, 30_000, 10_000_000])
def test_renewing_the_origin_of_the_weights_changes_nothing(tau_us: int) -> None:
    # The origin is renewed after 300 τ or 17 s: at least once in 40 s.
    config = FlyConfig(tau_us=tau_us, averaging=Averaging.NONE)
    times = [0, 7_000, 16_777_000, 16_790_000, 39_960_000, 39_970_000, 39_990_000]
    events = events_of([(t, 4, 4, True) for t in times])
    lags = np.array([10_000, 30_000, 20_000])
    expected = np.exp(-lags / tau_us).sum()
    assert surfaces_at(events, config, 40_000_000)[1, 1, 1] == pytest.approx(expected, rel=1e-6)


def test_the_delayed_signal_is_the_mean_over_the_delays() -> None:
    config = FlyConfig(delay_us=20_000, further_delays_us=(50_000,))
    surfaces = TimeSurfaces(config, width=WIDTH, height=HEIGHT)
    events = events_of([(t, 4 + t // 20_000, 4, True) for t in range(0, 120_000, 3_000)])
    taken, kept = 0, []
    for hop in range(12):
        surfaces.begin_hop(hop)
        taken = surfaces.accumulate(events, taken, until_us=(hop + 1) * 10_000)
        kept.append(surfaces.average(hop=hop))
    np.testing.assert_array_equal(surfaces.averaged(hop=8), kept[8])
    np.testing.assert_allclose(surfaces.delayed(hop=11), (kept[9] + kept[6]) / 2, rtol=1e-6)


def test_the_window_includes_its_start() -> None:
    config = FlyConfig(averaging=Averaging.NONE)
    pair = events_of([(9_999, 4, 4, False), (59_999, 4, 4, False)])
    late = events_of([(9_998, 4, 4, False), (59_999, 4, 4, False)])
    expected = math.exp(-50 / 30)
    assert surfaces_at(pair, config, 60_000)[0, 1, 1] == pytest.approx(expected, rel=1e-6)
    assert surfaces_at(late, config, 60_000)[0, 1, 1] == 0.0


def test_long_activity_accumulates_no_error() -> None:
    # In 40 s the origin of the weights is renewed more than four times.
    times = np.arange(0, 40_000_000, 500)
    events = events_of([(int(t), 4, 4, True) for t in times])
    terms = np.exp(-np.arange(500, 50_001, 500) / 30_000.0)
    end_us = 40_000_000
    assert surfaces_at(events, FlyConfig(), end_us)[1, 1, 1] == pytest.approx(terms.sum(), rel=1e-6)


def test_memory_does_not_grow_with_the_stream() -> None:
    config = FlyConfig()
    surfaces = TimeSurfaces(config, width=WIDTH, height=HEIGHT)
    events = np.zeros(600_000, EVENT_DTYPE)
    events["t"] = np.arange(600_000)
    sizes = []
    for hop in range(60):
        surfaces.begin_hop(hop)
        first, until_us = hop * 10_000, (hop + 1) * 10_000
        surfaces.accumulate(events, first, until_us=until_us)
        sizes.append(surfaces.memory_bytes)
    assert sizes[-1] == sizes[10]
