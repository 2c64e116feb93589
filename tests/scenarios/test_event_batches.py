from dataclasses import fields
from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from flybench.events import Cause
from scenarios.recording.event_batches import EventBatches, EventBuffer, batch, class_id
from tests.scenarios.drawn_events import events_at


def test_a_batch_holds_one_millisecond() -> None:
    got = batch(events_at(0, 999, 1_000, 5_500), np.zeros(4, np.uint8))
    np.testing.assert_array_equal(got.t_us, [1_000, 2_000, 6_000])
    np.testing.assert_array_equal(got.lengths, [2, 1, 1])
    np.testing.assert_array_equal(got.on, [1, 1, 0])
    np.testing.assert_array_equal(got.off, [1, 0, 1])


def test_what_noise_made_is_counted_and_told_apart() -> None:
    causes = np.array([Cause.SIGNAL, Cause.LEAK, Cause.HOT], np.uint8)
    got = batch(events_at(10, 20, 30), causes)
    np.testing.assert_array_equal(got.noise, [2])
    assert list(got.class_ids) == [
        class_id(Cause.SIGNAL, on=True),
        class_id(Cause.LEAK, on=False),
        class_id(Cause.HOT, on=True),
    ]


def test_every_cause_and_polarity_has_its_own_class() -> None:
    classes = {class_id(cause, on=on) for cause in Cause for on in (False, True)}
    assert len(classes) == 2 * len(Cause)


def test_a_millisecond_that_may_go_on_is_kept() -> None:
    buffer = EventBuffer(enough=1)
    assert buffer.push(events_at(100, 200)) is None
    over = buffer.push(events_at(300, 1_100))
    assert over is not None
    np.testing.assert_array_equal(over.lengths, [3])
    rest = buffer.flush()
    assert rest is not None
    np.testing.assert_array_equal(rest.t_us, [2_000])
    assert buffer.flush() is None


times = st.lists(st.integers(0, 20_000), max_size=60).map(sorted)


@given(times, st.lists(st.integers(1, 20), max_size=20), st.integers(1, 30))
def test_how_a_stream_is_cut_changes_no_millisecond(
    times_us: list[int], cuts: list[int], enough: int
) -> None:
    events, buffer = events_at(*times_us), EventBuffer(enough=enough)
    causes = np.arange(events.size).astype(np.uint8) % 4
    bounds = [0, *np.cumsum(cuts).tolist(), events.size]
    parts = [buffer.push(events[a:b], causes[a:b]) for a, b in pairwise(bounds) if a <= b]
    got = [part for part in (*parts, buffer.flush()) if part is not None]
    whole = batch(events, causes)
    for field in fields(EventBatches):
        pieces = [getattr(part, field.name) for part in got]
        expected = getattr(whole, field.name)
        joined = np.concatenate([expected[:0], *pieces])
        np.testing.assert_array_equal(joined, expected, err_msg=field.name)
