import numpy as np
import pytest

from detector.errors import EventOrderError
from detector.windowed import QUIET_LIMIT_US, HopBuffer
from flybench.errors import EventError
from flybench.events import EVENT_DTYPE, Events


def at(*times_us: int) -> Events:
    events = np.zeros(len(times_us), EVENT_DTYPE)
    events["t"] = times_us
    return events


def told(done: object) -> list[tuple[int, list[int]]]:
    return [(end_us, events["t"].tolist()) for end_us, events in done]  # type: ignore[attr-defined]


def hops() -> HopBuffer:
    return HopBuffer(10, width=4, height=4)


def test_a_hop_is_handed_out_when_the_next_has_begun() -> None:
    stream = hops()
    assert told(stream.push(at(3, 9))) == []
    assert told(stream.push(at(10, 25))) == [(10, [3, 9]), (20, [10])]
    assert told(stream.advance(40)) == [(30, [25]), (40, [])]


def test_cuts_do_not_matter() -> None:
    times = [0, 3, 9, 10, 10, 25, 31, 47, 48]
    one, many = hops(), hops()
    whole = told(one.push(at(*times))) + told(one.advance(60))
    pieces = [hop for t in times for hop in told(many.push(at(t)))] + told(many.advance(60))
    assert pieces == whole


def test_the_events_are_its_own() -> None:
    stream, events = hops(), at(3)
    stream.push(events)
    events["t"] = 7
    assert told(stream.advance(10)) == [(10, [3])]


def test_a_long_silence_is_passed_over() -> None:
    stream = HopBuffer(10_000_000, width=4, height=4)
    late_us = 3_600_000_000
    assert len(told(stream.push(at(5)))) == 0
    assert len(told(stream.advance(late_us))) == QUIET_LIMIT_US // 10_000_000
    assert told(stream.push(at(late_us + 1))) == []
    assert told(stream.advance(late_us + 10_000_000)) == [(late_us + 10_000_000, [late_us + 1])]


def test_a_late_stream_starts_with_its_first_event() -> None:
    stream, late_us = hops(), 2 * QUIET_LIMIT_US
    assert told(stream.push(at(late_us + 3, late_us + 12))) == [(late_us + 10, [late_us + 3])]


@pytest.mark.parametrize("told_us", [QUIET_LIMIT_US + 1, 3 * QUIET_LIMIT_US])
def test_time_told_before_a_late_first_event_changes_nothing(told_us: int) -> None:
    stream, late_us = hops(), 3 * QUIET_LIMIT_US
    assert told(stream.advance(told_us)) == []
    assert told(stream.push(at(late_us + 3, late_us + 12))) == [(late_us + 10, [late_us + 3])]


def test_what_is_refused_changes_nothing() -> None:
    stream = hops()
    stream.push(at(9))
    with pytest.raises(EventOrderError, match="8"):
        stream.push(at(8))
    with pytest.raises(EventError):
        stream.push(at(12, 11))
    with pytest.raises(EventOrderError):
        stream.advance(8)
    assert told(stream.advance(10)) == [(10, [9])]
