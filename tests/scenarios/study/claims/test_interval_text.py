"""The text of a mean and its interval."""

import pytest

from scenarios.study.claims.claim import format_interval
from scenarios.study.statistics import Interval


@pytest.mark.parametrize(
    ("interval", "wanted"),
    [
        (Interval(mean=0.908, low=0.9, high=0.917, number=5), "90.8 % (90 to 91.7)"),
        (Interval(mean=1.0, low=1.0, high=1.0, number=5), "100 %"),
        (Interval(mean=0.27101, low=0.271, high=0.27102, number=5), "27.1 %"),
        (Interval(mean=0.5, low=0.2, high=0.8, number=1), "50 %"),
        (None, "no value"),
    ],
)
def test_an_interval_that_is_one_number_is_left_out(interval: Interval | None, wanted: str) -> None:
    assert format_interval(interval, "%") == wanted
