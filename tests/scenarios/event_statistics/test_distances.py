import math
from dataclasses import replace

import numpy as np
import pytest

from scenarios.event_statistics.distances import (
    difference,
    interval_distance,
    log_ratio,
    noise_distance,
)
from scenarios.event_statistics.interval_histogram import BINS
from scenarios.event_statistics.noise import NoiseClass

NOISE = NoiseClass(
    from_brightness=None, pixels=1000, seconds=2.0, on=60, off=40, silent=0.9, spread=0.0
)


def at(*bins: int) -> np.ndarray:
    return np.bincount(bins, minlength=BINS)


def test_a_factor_counts_the_same_up_and_down() -> None:
    assert log_ratio(3.0, 6.0) == log_ratio(6.0, 3.0) == pytest.approx(math.log(2))
    assert log_ratio(2.0, 2.0) == 0.0
    assert log_ratio(0.0, 1.0) is log_ratio(None, 1.0) is None


def test_shares_differ_by_their_difference() -> None:
    assert difference(0.25, 0.75) == difference(0.75, 0.25) == 0.5
    assert difference(None, 0.5) is None


def test_intervals_that_all_double_have_a_distance_of_ln_2() -> None:
    assert interval_distance(at(10, 20, 40), at(20, 40, 80)) == pytest.approx(math.log(2))
    assert interval_distance(at(10, 20), at(20, 10, 20, 10)) == pytest.approx(0.0)
    assert interval_distance(at(10), at()) is None


def test_noise_without_events_is_compared_as_half_an_event() -> None:
    silent = replace(NOISE, on=0, off=0)
    assert noise_distance(NOISE, silent) == pytest.approx(math.log(100.5 / 0.5))
    longer = replace(NOISE, seconds=4.0, on=120, off=80)
    assert noise_distance(NOISE, longer) == pytest.approx(0.0, abs=0.01)
    assert noise_distance(NOISE, replace(NOISE, pixels=99)) is None
