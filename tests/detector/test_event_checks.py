import numpy as np
import pytest

from detector.errors import DetectorError, EventOrderError
from detector.event_checks import check_chunk, check_order, whole_time
from flybench.errors import EventError
from flybench.events import EVENT_DTYPE, Events, empty_events


def make(*rows: tuple[int, int, int, int]) -> Events:
    return np.array(list(rows), EVENT_DTYPE)


def check(events: Events, *, now_us: int = 0) -> None:
    check_chunk(events, width=346, height=260, now_us=now_us)


def test_accepts_the_corners_and_equal_times() -> None:
    check(make((5, 0, 0, 0), (5, 345, 259, 1)), now_us=5)
    check(empty_events(), now_us=5)


@pytest.mark.parametrize(
    ("events", "sentence"),
    [
        (make((5, 0, 0, 0), (4, 0, 0, 0)), "event 1 has t = 4 µs after t = 5 µs"),
        (make((5, 346, 0, 0)), "x = 346; allowed is 0 to 345"),
        (make((5, 0, -1, 0)), "y = -1; allowed is 0 to 259"),
        (np.zeros(3), "dtype float64"),
        (np.zeros((2, 2), EVENT_DTYPE), "2 dimensions"),
    ],
)
def test_refuses_what_is_no_stream(events: Events, sentence: str) -> None:
    with pytest.raises(EventError, match=sentence):
        check(events)


def test_refuses_a_polarity_that_is_neither() -> None:
    events = make((5, 0, 0, 1))
    events.view([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "u1")])["p"] = 7
    with pytest.raises(EventError, match="polarity byte 7; allowed is 0"):
        check(events)


def test_time_that_goes_back_between_calls_is_an_error_of_both_packages() -> None:
    with pytest.raises(EventOrderError, match="time 4 µs comes after time 5 µs") as caught:
        check(make((4, 0, 0, 0)), now_us=5)
    assert isinstance(caught.value, DetectorError)
    assert isinstance(caught.value, EventError)


@pytest.mark.parametrize("bad", [float("nan"), 5.0, "5", None])
def test_refuses_a_time_that_is_no_whole_number(bad: object) -> None:
    with pytest.raises(EventOrderError, match=f"time is {bad!r}; allowed is a whole number of µs"):
        whole_time(bad)  # type: ignore[arg-type]


def test_a_whole_number_of_numpy_becomes_a_plain_one() -> None:
    assert type(whole_time(np.int64(5))) is int  # type: ignore[arg-type]


def test_a_time_beyond_any_stream_or_before_0_is_refused() -> None:
    assert whole_time(2**62) == 2**62
    with pytest.raises(EventOrderError, match=f"time is {2**63} µs; allowed is up to {2**62} µs"):
        whole_time(2**63)
    with pytest.raises(EventOrderError, match="times start at 0; subtract the first time"):
        check(make((-5, 0, 0, 0)))
    check(make((2**62, 0, 0, 0)))
    with pytest.raises(EventOrderError, match=f"time is {2**63 - 1} µs; allowed is up to"):
        check(make((5, 0, 0, 0), (2**63 - 1, 0, 0, 0)))


def test_the_present_is_in_order() -> None:
    check_order(5, 5)
    with pytest.raises(EventOrderError):
        check_order(4, 5)
