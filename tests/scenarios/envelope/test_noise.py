"""Poisson noise and merging of streams."""

import numpy as np
import pytest

from flybench.events import EVENT_DTYPE, check_events
from scenarios.envelope.noise import merge_streams, poisson_noise

SIZE = {"width": 40, "height": 30}


@pytest.mark.parametrize("rate_hz", [0.5, 20.0])
def test_noise_is_poisson_in_every_pixel(rate_hz: float) -> None:
    rng = np.random.default_rng(0)
    events = poisson_noise(rate_hz, **SIZE, duration_us=10_000_000, rng=rng)
    check_events(events, **SIZE)
    assert 0 <= events["t"].min() <= events["t"].max() < 10_000_000
    by_pixel = np.bincount(events["y"].astype(int) * 40 + events["x"], minlength=1200)
    assert by_pixel.mean() == pytest.approx(rate_hz * 10, rel=0.05)
    assert by_pixel.var() == pytest.approx(rate_hz * 10, rel=0.15)
    assert events["p"].mean() == pytest.approx(0.5, abs=0.02)
    by_tenth, _ = np.histogram(events["t"], 10, (0, 10_000_000))
    assert by_tenth.std() < 4 * np.sqrt(events.size / 10)


def test_a_rate_of_zero_gives_no_noise() -> None:
    rng = np.random.default_rng(0)
    assert poisson_noise(0.0, **SIZE, duration_us=1_000_000, rng=rng).size == 0


@pytest.mark.parametrize(("first", "second"), [(0, 0), (5, 0), (0, 5), (200, 300)])
def test_merging_is_a_stable_sort(first: int, second: int) -> None:
    rng = np.random.default_rng(1)
    streams = []
    for k, size in enumerate((first, second)):
        events = np.zeros(size, EVENT_DTYPE)
        events["t"] = np.sort(rng.integers(0, 100, size))
        events["x"], events["y"] = np.arange(size), k
        streams.append(events)
    both = np.concatenate(streams)
    expected = both[np.argsort(both["t"], kind="stable")]
    np.testing.assert_array_equal(merge_streams(*streams), expected)
