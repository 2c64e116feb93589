import numpy as np

from flybench.events import EVENT_DTYPE, Events, concatenate_events


def some_events(number: int) -> Events:
    events = np.empty(number, EVENT_DTYPE)
    rng = np.random.default_rng(0)
    events["t"] = np.sort(rng.integers(1 << 40, size=number))
    events["x"], events["y"] = rng.integers(-5, 300, (2, number))
    events["p"] = rng.integers(2, size=number) > 0
    return events


def test_parts_are_joined_in_order_and_copied() -> None:
    events = some_events(50)
    whole = concatenate_events([events[:20], events[:0], events[20:]])
    np.testing.assert_array_equal(whole, events)
    assert whole.dtype == EVENT_DTYPE
    assert not np.shares_memory(concatenate_events([events]), events)


def test_parts_may_leave_gaps_in_memory() -> None:
    events = some_events(50)
    np.testing.assert_array_equal(concatenate_events([events[::2], events[::-1]])[:25], events[::2])


def test_no_parts_are_no_events() -> None:
    assert concatenate_events([]).dtype == EVENT_DTYPE
    assert concatenate_events([]).size == 0
