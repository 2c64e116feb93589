import numpy as np
import pytest

from flybench.kernels import compiled
from scenarios.event_statistics.interval_histogram import (
    BINS,
    bin_centres_us,
    bin_edges_us,
    interval_bin,
    quantile_us,
)


@compiled
def bin_of(interval_us: int) -> int:
    return interval_bin(interval_us)


def histogram_of(*intervals_us: int) -> np.ndarray:
    histogram = np.zeros(BINS, np.int64)
    np.add.at(histogram, [bin_of(interval) for interval in intervals_us], 1)
    return histogram


@pytest.mark.parametrize("interval_us", [0, 1, 127, 128, 129, 255, 256, 1000, 30_000, 10**9])
def test_an_interval_lies_between_the_edges_of_its_bin(interval_us: int) -> None:
    edges, k = bin_edges_us(), bin_of(interval_us)
    assert edges[k] <= interval_us < edges[k + 1]
    assert edges[k + 1] - edges[k] <= max(1.0, interval_us / 64)


def test_the_edges_increase_up_to_50_days_and_longer_intervals_are_in_the_last_bin() -> None:
    edges = bin_edges_us()
    assert (np.diff(edges) >= 1).all()
    assert edges[-1] == 2**42
    assert bin_of(2**42 - 1) == bin_of(2**60) == BINS - 1
    assert (np.diff(bin_centres_us()) > 0).all()


def test_quantiles_are_exact_below_128_us() -> None:
    histogram = histogram_of(*range(1, 101))
    assert quantile_us(histogram, 0.01) == 1
    assert quantile_us(histogram, 0.5) == 50
    assert quantile_us(histogram, 1.0) == 100
    assert quantile_us(histogram_of(0, 0), 0.5) == 0.5


def test_long_quantiles_are_right_to_one_percent() -> None:
    assert quantile_us(histogram_of(12_345), 0.5) == pytest.approx(12_345, rel=0.01)


def test_no_interval_has_no_quantile() -> None:
    assert quantile_us(histogram_of(), 0.5) is None
