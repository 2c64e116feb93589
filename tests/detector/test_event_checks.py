import numpy as np
import pytest

from detector.errors import DetectorError, EventOrderError
from detector.event_checks import check_chunk, check_order, checked_time
from flybench.errors import EventError
from flybench.events import EVENT_DTYPE, Events, empty_events


def make(*rows: tuple[int, int, int, int]) -> Events:
    return np.array(list(rows), EVENT_DTYPE)


def check(events: Events, *, now_us: int = 0) -> None:
    check_chunk(events, width=346, height=260, now_us=now_us)


def test_accepts_corner_pixels_and_equal_times() -> None:
    check(make((5, 0, 0, 0), (5, 345, 259, 1)), now_us=5)
    check(empty_events(), now_us=5)


@pytest.mark.parametrize(
    ("events", "sentence"),
    [
        (make((5, 0, 0, 0), (4, 0, 0, 0)), "Event 1 has t = 4 µs after t = 5 µs"),
        (make((5, 346, 0, 0)), "x = 346"),
        (make((5, 0, -1, 0)), "y = -1"),
        (np.zeros(3), "dtype float64"),
        (np.zeros((2, 2), EVENT_DTYPE), "2 dimensions"),
    ],
)
def test_refuses_what_is_not_a_stream(events: Events, sentence: str) -> None:
    with pytest.raises(EventError, match=sentence):
        check(events)


def test_refuses_a_polarity_byte_that_is_neither_on_nor_off() -> None:
    events = make((5, 0, 0, 1))
    events.view([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "u1")])["p"] = 7
    with pytest.raises(EventError, match=r"polarity byte 7\. Allowed is 0"):
        check(events)


def test_time_that_goes_back_between_calls_raises_an_error_of_detectors_and_of_events() -> None:
    with pytest.raises(EventOrderError, match="Time 4 µs comes after time 5 µs") as caught:
        check(make((4, 0, 0, 0)), now_us=5)
    assert isinstance(caught.value, DetectorError)
    assert isinstance(caught.value, EventError)


@pytest.mark.parametrize("bad", [float("nan"), 5.0, "5", None])
def test_refuses_a_time_that_is_not_a_whole_number(bad: object) -> None:
    with pytest.raises(
        EventOrderError, match=rf"time is {bad!r}\. Allowed is a whole number of µs"
    ):
        checked_time(bad)  # type: ignore[arg-type]


def test_converts_a_whole_number_of_numpy_to_an_int() -> None:
    assert type(checked_time(np.int64(5))) is int  # type: ignore[arg-type]


def test_refuses_a_time_that_is_too_late_or_before_0() -> None:
    assert checked_time(2**62) == 2**62
    with pytest.raises(EventOrderError, match=rf"time is {2**63} µs\. Allowed is up to {2**62} µs"):
        checked_time(2**63)
    with pytest.raises(EventOrderError, match=r"times start at 0\. Subtract the first time"):
        check(make((-5, 0, 0, 0)))
    check(make((2**62, 0, 0, 0)))
    with pytest.raises(EventOrderError, match=rf"time is {2**63 - 1} µs\. Allowed is up to"):
        check(make((5, 0, 0, 0), (2**63 - 1, 0, 0, 0)))


def test_allows_the_time_that_the_stream_has_reached() -> None:
    check_order(5, 5)
    with pytest.raises(EventOrderError):
        check_order(4, 5)
