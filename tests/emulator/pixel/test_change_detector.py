import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from emulator.pixel.change_detector import (
    NEVER_US,
    THETA_MIN,
    Course,
    difference,
    draw_thresholds,
    first_crossing,
    stays_within,
)

ON, OFF = 0.18, 0.22

given_course = given(
    start=st.floats(-0.2, 0.17),
    rate=st.floats(-3e-3, 3e-3),
    swing=st.floats(-2, 2),
    tau=st.floats(1, 1e4),
    span=st.floats(1, 5000),
)


@pytest.mark.parametrize(("rate", "expected_us"), [(1e-3, 180.0), (-1e-3, 220.0)])
def test_crossing_of_a_straight_line(rate: float, expected_us: float) -> None:
    crossing, on = first_crossing(Course(0.0, rate, 0.0, 50.0), 1000.0, ON, OFF)
    assert crossing == pytest.approx(expected_us, abs=1e-3)
    assert on == (rate > 0)


def test_crossing_of_an_exponential() -> None:
    crossing, on = first_crossing(Course(0.0, 0.0, 1.0, 100.0), 1000.0, ON, OFF)
    assert on
    assert crossing == pytest.approx(-100.0 * math.log(1 - ON), abs=1e-3)


def test_a_crossing_that_reverses_within_the_span_is_found() -> None:
    rate, swing, tau = -1e-3, 0.5, 50.0
    assert difference(Course(0.0, rate, swing, tau), 500.0) < ON
    crossing, on = first_crossing(Course(0.0, rate, swing, tau), 500.0, ON, OFF)
    assert on
    assert difference(Course(0.0, rate, swing, tau), crossing) == pytest.approx(ON, abs=1e-5)
    decay = math.exp(-500.0 / tau)
    assert not stays_within(Course(0.0, rate, swing, tau), 500.0, decay, ON, OFF)


@given_course
def test_the_earliest_crossing_is_found(
    start: float, rate: float, swing: float, tau: float, span: float
) -> None:
    s = np.linspace(0.0, span, 20_001)
    d = start + rate * s + swing * (1.0 - np.exp(-s / tau))
    outside = np.flatnonzero((d >= ON) | (d <= -OFF))
    assume(abs(d.max() - ON) > 1e-6)
    assume(abs(d.min() + OFF) > 1e-6)
    crossing, on = first_crossing(Course(start, rate, swing, tau), span, ON, OFF)
    if outside.size == 0:
        assert crossing == NEVER_US
        return
    first = int(outside[0])
    assert s[first - 1] - 2e-3 <= crossing <= s[first] + 2e-3
    assert on == (d[first] >= ON)


@given_course
def test_the_quick_test_is_never_wrong(
    start: float, rate: float, swing: float, tau: float, span: float
) -> None:
    if stays_within(Course(start, rate, swing, tau), span, math.exp(-span / tau), ON, OFF):
        assert first_crossing(Course(start, rate, swing, tau), span, ON, OFF)[0] == NEVER_US


def test_thresholds_are_gaussian_and_at_least_the_minimum() -> None:
    drawn = draw_thresholds(0.18, 0.035, 100_000, np.random.default_rng(1))
    assert drawn.mean() == pytest.approx(0.18, abs=1e-3)
    assert drawn.std() == pytest.approx(0.035, rel=0.02)
    wide = draw_thresholds(0.18, 0.5, 10_000, np.random.default_rng(1))
    assert wide.min() == np.float32(THETA_MIN)
