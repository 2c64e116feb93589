import numpy as np
import pytest

from detector.plane_fit.surface_slopes import FitLimits, SurfaceSlopes
from flybench.events import EVENT_DTYPE, Events


def surface() -> SurfaceSlopes:
    limits = FitLimits(
        radius_px=2, span_us=100_000, burst_us=1_000, least_neighbours=10, tolerance_px=0.5
    )
    return SurfaceSlopes(limits, width=40, height=30)


def edge(a_us: float, b_us: float, *, polarity: bool = True) -> Events:
    """Return one event per pixel at t = a·x + b·y, from an edge that crosses the whole sensor."""
    y, x = np.mgrid[0:30, 0:40]
    events = np.zeros(x.size, EVENT_DTYPE)
    t = a_us * x + b_us * y
    events["t"] = (t - t.min()).ravel().round()
    events["x"], events["y"], events["p"] = x.ravel(), y.ravel(), polarity
    return events[np.argsort(events["t"], kind="stable")]


@pytest.mark.parametrize(
    ("a_us", "b_us"), [(2000.0, 0.0), (-2000.0, 0.0), (0.0, 3000.0), (1500.0, -700.0)]
)
def test_the_slope_is_that_of_the_event_times(a_us: float, b_us: float) -> None:
    slopes = surface().fit(edge(a_us, b_us))
    assert len(slopes) > 700
    np.testing.assert_allclose(np.median(slopes, axis=0) * 1e6, (a_us, b_us), atol=20.0)


def test_cuts_between_chunks_do_not_matter() -> None:
    events, whole, pieces = edge(1500.0, -700.0), surface(), surface()
    expected = whole.fit(events)
    found = np.concatenate([pieces.fit(events[n : n + 100]) for n in range(0, 1200, 100)])
    np.testing.assert_array_equal(found, expected)


def test_only_the_first_event_of_a_burst_counts() -> None:
    events = edge(2000.0, 0.0)
    echo = events.copy()
    echo["t"] += 700
    both = np.concatenate([events, echo])
    both = both[np.argsort(both["t"], kind="stable")]
    np.testing.assert_allclose(surface().fit(both), surface().fit(events))


def test_an_older_edge_ahead_does_not_matter() -> None:
    first, second = edge(2000.0, 0.0), edge(2000.0, 0.0)
    second["t"] += 20_000
    both = np.concatenate([first, second])
    both = both[np.argsort(both["t"], kind="stable")]
    slopes = surface().fit(both)
    assert np.mean(np.abs(slopes[:, 0] - 2e-3) < 2e-4) > 0.95


def test_polarities_have_separate_surfaces() -> None:
    on, off = edge(2000.0, 0.0), edge(-2000.0, 0.0, polarity=False)
    both = np.concatenate([on, off])
    slopes = surface().fit(both[np.argsort(both["t"], kind="stable")])
    assert np.isclose(np.abs(slopes[:, 0]), 2e-3, rtol=0.05).mean() > 0.95


def test_isolated_and_simultaneous_events_have_no_slope() -> None:
    assert len(surface().fit(edge(2000.0, 0.0)[::40])) == 0
    same_time = edge(0.0, 0.0)
    assert len(surface().fit(same_time)) == 0
