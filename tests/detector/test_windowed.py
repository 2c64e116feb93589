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


def times_by_hop(hops: list[tuple[int, Events]]) -> list[tuple[int, list[int]]]:
    """Return the end of each hop and the times of its events."""
    return [(end_us, events["t"].tolist()) for end_us, events in hops]


def hop_buffer() -> HopBuffer:
    return HopBuffer(10, width=4, height=4)


def test_a_hop_is_returned_when_the_next_has_begun() -> None:
    stream = hop_buffer()
    assert times_by_hop(stream.push(at(3, 9))) == []
    assert times_by_hop(stream.push(at(10, 25))) == [(10, [3, 9]), (20, [10])]
    assert times_by_hop(stream.advance(40)) == [(30, [25]), (40, [])]


def test_cuts_between_chunks_do_not_matter() -> None:
    times = [0, 3, 9, 10, 10, 25, 31, 47, 48]
    one, many = hop_buffer(), hop_buffer()
    whole = times_by_hop(one.push(at(*times))) + times_by_hop(one.advance(60))
    pieces = [hop for t in times for hop in times_by_hop(many.push(at(t)))] + times_by_hop(
        many.advance(60)
    )
    assert pieces == whole


def test_the_buffer_copies_events() -> None:
    stream, events = hop_buffer(), at(3)
    stream.push(events)
    events["t"] = 7
    assert times_by_hop(stream.advance(10)) == [(10, [3])]


def test_hops_stop_at_the_quiet_limit() -> None:
    stream = HopBuffer(10_000_000, width=4, height=4)
    late_us = 3_600_000_000
    assert len(times_by_hop(stream.push(at(5)))) == 0
    assert len(times_by_hop(stream.advance(late_us))) == QUIET_LIMIT_US // 10_000_000
    assert times_by_hop(stream.push(at(late_us + 1))) == []
    assert times_by_hop(stream.advance(late_us + 10_000_000)) == [
        (late_us + 10_000_000, [late_us + 1])
    ]


def test_a_late_stream_starts_with_its_first_event() -> None:
    stream, late_us = hop_buffer(), 2 * QUIET_LIMIT_US
    assert times_by_hop(stream.push(at(late_us + 3, late_us + 12))) == [
        (late_us + 10, [late_us + 3])
    ]


@pytest.mark.parametrize("early_us", [QUIET_LIMIT_US + 1, 3 * QUIET_LIMIT_US])
def test_an_advance_before_a_late_first_event_changes_nothing(early_us: int) -> None:
    stream, late_us = hop_buffer(), 3 * QUIET_LIMIT_US
    assert times_by_hop(stream.advance(early_us)) == []
    assert times_by_hop(stream.push(at(late_us + 3, late_us + 12))) == [
        (late_us + 10, [late_us + 3])
    ]


def test_a_refused_call_changes_nothing() -> None:
    stream = hop_buffer()
    stream.push(at(9))
    with pytest.raises(EventOrderError, match="8"):
        stream.push(at(8))
    with pytest.raises(EventError):
        stream.push(at(12, 11))
    with pytest.raises(EventOrderError):
        stream.advance(8)
    assert times_by_hop(stream.advance(10)) == [(10, [9])]
