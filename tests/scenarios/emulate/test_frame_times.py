"""Times of frames, and the rate that is shown."""

from fractions import Fraction

import numpy as np
import pytest

from scenarios.emulate.frame_times import FrameTimes, evenly_spaced, own_times
from scenarios.errors import ScenarioError


@pytest.mark.parametrize(
    ("t_us", "rate"),
    [
        ([0, 16_667, 33_333, 50_000], "60 Hz"),
        ([0, 33_000, 67_000, 100_000], "30 Hz"),  # whole ms
        ([0, 33_001, 67_000, 100_000], "29.4 to 30.3 Hz, varies"),
        ([0, 50_001, 99_998, 150_007], "20 Hz"),  # jitter that three digits do not show
        ([0, 1000, 2000, 4000], "500 to 1000 Hz, varies"),
        ([0, 10], "100000 Hz"),
    ],
)
def test_the_rate_or_its_range_is_shown(t_us: list[int], rate: str) -> None:
    assert FrameTimes(np.array(t_us, np.int64), "").rate() == rate


def test_a_constant_rate_is_shown_as_it_was_given() -> None:
    times = evenly_spaced(3, 23.976, "stated")
    assert (times.rate(), times.t_us.tolist()) == ("23.976 Hz", [0, 41_708, 83_417])


def test_times_of_nanoseconds_since_1970_keep_their_digits() -> None:
    first = Fraction(1403636579763555584, 1000)
    times = own_times([first, first + 12, first + 49_999], ["a", "b", "c"], "names")
    assert times.t_us.tolist() == [0, 12, 49_999]


@pytest.mark.parametrize("step_us", [0, 9, -5, 2 * 10**9, 10**40])
def test_frames_too_close_or_too_far_apart_are_refused(step_us: int) -> None:
    with pytest.raises(ScenarioError, match=r"b is .* s after a \(names\)\. Allowed is 1e-05 to"):
        own_times([Fraction(0), Fraction(step_us)], ["a", "b"], "names")
