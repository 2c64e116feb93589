"""Matching the events of two streams."""

import numpy as np
import pytest

from flybench.events import EVENT_DTYPE, Events
from scenarios.convergence.matching import match


def stream(*rows: tuple[int, int, int, bool]) -> Events:
    return np.array(list(rows), EVENT_DTYPE)


def test_an_event_matches_the_nearest_one_of_its_pixel_and_polarity() -> None:
    reference = stream((100, 1, 2, True), (5000, 1, 2, True), (9000, 3, 2, False))
    events = stream((4700, 1, 2, True), (5600, 1, 2, True), (9000, 3, 2, True))
    result = match(events, reference)
    assert result.excess == 0
    assert result.precision == pytest.approx((0, 1 / 3, 2 / 3, 2 / 3))
    assert result.recall == pytest.approx((0, 1 / 3, 1 / 3, 1 / 3))
    assert result.median_us == 450


def test_a_stream_matches_itself() -> None:
    rng = np.random.default_rng(0)
    events = np.zeros(500, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, 10_000, 500))
    events["x"], events["y"] = rng.integers(0, 346, 500), rng.integers(0, 260, 500)
    result = match(events, events)
    assert result.recall == result.precision == (1, 1, 1, 1)
    assert result.median_us == 0
