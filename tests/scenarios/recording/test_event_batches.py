"""Events grouped into milliseconds."""

from dataclasses import fields
from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from flybench.events import Cause
from scenarios.recording.event_batches import EventBatches, EventBuffer, batch_events, class_id
from tests.scenarios.timed_events import events_at


def test_a_batch_holds_one_millisecond() -> None:
    got = batch_events(events_at(0, 999, 1_000, 5_500), np.zeros(4, np.uint8))
    np.testing.assert_array_equal(got.t_us, [1_000, 2_000, 6_000])
    np.testing.assert_array_equal(got.lengths, [2, 1, 1])
    np.testing.assert_array_equal(got.on, [1, 1, 0])
    np.testing.assert_array_equal(got.off, [1, 0, 1])


def test_noise_events_are_counted_and_have_their_own_classes() -> None:
    causes = np.array([Cause.SIGNAL, Cause.LEAK, Cause.HOT], np.uint8)
    got = batch_events(events_at(10, 20, 30), causes)
    np.testing.assert_array_equal(got.noise, [2])
    assert list(got.class_ids) == [
        class_id(Cause.SIGNAL, on=True),
        class_id(Cause.LEAK, on=False),
        class_id(Cause.HOT, on=True),
    ]


def test_every_cause_and_polarity_has_its_own_class() -> None:
    classes = {class_id(cause, on=on) for cause in Cause for on in (False, True)}
    assert len(classes) == 2 * len(Cause)


def test_an_incomplete_millisecond_stays_in_the_buffer() -> None:
    buffer = EventBuffer(chunk_events=1)
    assert buffer.push(events_at(100, 200)) is None
    complete = buffer.push(events_at(300, 1_100))
    assert complete is not None
    np.testing.assert_array_equal(complete.lengths, [3])
    rest = buffer.flush()
    assert rest is not None
    np.testing.assert_array_equal(rest.t_us, [2_000])
    assert buffer.flush() is None


times = st.lists(st.integers(0, 20_000), max_size=60).map(sorted)


@given(times, st.lists(st.integers(1, 20), max_size=20), st.integers(1, 30))
def test_chunks_do_not_change_the_batches(
    times_us: list[int], cuts: list[int], chunk_events: int
) -> None:
    events, buffer = events_at(*times_us), EventBuffer(chunk_events=chunk_events)
    causes = np.arange(events.size).astype(np.uint8) % 4
    bounds = [0, *np.cumsum(cuts).tolist(), events.size]
    parts = [buffer.push(events[a:b], causes[a:b]) for a, b in pairwise(bounds) if a <= b]
    got = [part for part in (*parts, buffer.flush()) if part is not None]
    whole = batch_events(events, causes)
    for field in fields(EventBatches):
        pieces = [getattr(part, field.name) for part in got]
        expected = getattr(whole, field.name)
        joined = np.concatenate([expected[:0], *pieces])
        np.testing.assert_array_equal(joined, expected, err_msg=field.name)
