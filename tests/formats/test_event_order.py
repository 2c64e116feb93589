"""Restore the order of events in time, or refuse the first that is late."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flybench.events import Events
from formats import FormatError, event_order, open_events, read_events
from formats.columns import PARSED_DTYPE, ReadOptions
from formats.event_order import TimeOrder
from tests.formats.sample_files import SIZE, make_file, random_events

PATH = Path("a.npy")


def at(times: list[int]) -> Events:
    """Return events at these times, numbered by y."""
    events = np.zeros(len(times), PARSED_DTYPE)
    events["t"], events["y"] = times, np.arange(len(times))
    return events


def ordered(
    times: list[int], cuts: list[int], *, window_us: int = 0, drop: bool = False
) -> tuple[list[int], TimeOrder, str]:
    order = TimeOrder(PATH, ReadOptions(sort_within_us=window_us, drop_unsorted=drop))
    got: list[int] = []
    try:
        for part in np.split(at(times), sorted(cuts)):
            for events in order.push(part) if part.size else ():
                got += events["t"].tolist()
        for events in order.finish():
            got += events["t"].tolist()
    except FormatError as error:
        return got, order, str(error)
    return got, order, ""


def test_a_late_event_is_refused_after_those_before_it() -> None:
    got, _, error = ordered([1, 5, 9, 8, 10], [])
    assert got == [1, 5, 9]
    assert "event 3 has the time 8 µs, after one at 9 µs" in error
    assert "--sort 1, or drop them with --drop-unsorted" in error
    assert ordered([1, 5, 9, 8, 10], [3])[0] == [1, 5, 9]


def test_events_within_the_window_are_sorted_and_counted() -> None:
    got, order, error = ordered([1, 9, 5, 7, 20, 12, 30], [2, 5], window_us=8)
    assert (got, order.sorted, order.dropped, error) == ([1, 5, 7, 9, 12, 20, 30], 3, 0, "")


def test_an_event_later_than_the_window_is_refused_after_those_before_it() -> None:
    got, _, error = ordered([1, 9, 5, 20, 3, 30], [2], window_us=8)
    assert got == [1, 5, 9, 20]
    assert "event 4 has the time 3 µs, after one at 20 µs" in error


def test_late_events_are_dropped_and_counted() -> None:
    got, order, _ = ordered([1, 5, 9, 2, 3, 10, 4], [2], drop=True)
    assert (got, order.dropped) == ([1, 5, 9, 10], 3)


def test_one_event_from_the_future_does_not_drop_those_after_it() -> None:
    for times in ([1, 900, 2, 3, 4], [900, 1, 2, 3, 4], [1, 2, 900, 3, 4], [1, 2, 3, 900, 4]):
        for cut in range(5):
            got, order, _ = ordered(times, [cut], drop=True)
            assert (got, order.dropped) == ([t for t in times if t < 900], 1)


def test_both_options_sort_what_is_in_the_window_and_drop_the_rest() -> None:
    got, order, _ = ordered([10, 20, 18, 900, 25, 24, 3, 30], [3], window_us=5, drop=True)
    assert (got, order.sorted, order.dropped) == ([10, 18, 20, 24, 25, 30], 2, 2)


@given(
    times=st.lists(st.integers(-50, 50), min_size=1, max_size=40),
    cuts=st.lists(st.integers(0, 40), max_size=4),
    window_us=st.integers(0, 30),
    drop=st.booleans(),
)
def test_any_order_in_any_chunks(
    times: list[int], cuts: list[int], window_us: int, drop: bool
) -> None:
    got, order, error = ordered(times, cuts, window_us=window_us, drop=drop)
    assert got == sorted(got)
    whole, at_once, same_error = ordered(times, [], window_us=window_us, drop=drop)
    assert (got, order.sorted, order.dropped, error) == (
        (whole, at_once.sorted, at_once.dropped, same_error)
    )
    if not error:
        assert len(got) + order.dropped == len(times)
        assert drop or got == sorted(times)


def test_more_events_than_fit_into_memory_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(event_order, "_HELD_MAX", 5)
    _, _, error = ordered(list(range(20)), [], window_us=10)
    assert "shorter time with --sort" in error


@pytest.mark.parametrize(
    "name", ["evt2.raw", "evt21.raw", "a.dat", "davis.aedat", "a.csv", "a.npy"]
)
def test_one_late_event_in_a_file(tmp_path: Path, name: str) -> None:
    events = random_events(2000)
    late = events.copy()
    late["t"][1000] = events["t"][999] - 40
    if name == "a.csv":  # flybench refuses to write such events
        path = tmp_path / name
        np.savetxt(path, np.stack([late[n] for n in "txyp"], 1), fmt="%d", delimiter=",")
    else:
        path = make_file(tmp_path, name, late)
    got: list[Events] = []
    with open_events(path, size=SIZE) as file, pytest.raises(FormatError, match="event 1000 has"):
        got.extend(chunk.events for chunk in file)
    assert np.array_equal(np.concatenate(got), events[:1000])
    with open_events(path, size=SIZE, sort_within_us=5000) as file:
        got = [chunk.events for chunk in file]
        assert (file.sorted_events, file.dropped_events) == (1, None)
    assert np.array_equal(np.sort(np.concatenate(got)["t"]), np.concatenate(got)["t"])
    with open_events(path, size=SIZE, drop_unsorted=True) as file:
        got = [chunk.events for chunk in file]
        assert (file.sorted_events, file.dropped_events) == (None, 1)
    assert np.array_equal(np.concatenate(got), np.delete(events, 1000))


@pytest.mark.parametrize("window_us", [-1, 10_000_001])
def test_a_wrong_window_is_refused(tmp_path: Path, window_us: int) -> None:
    path = make_file(tmp_path, "a.csv", random_events())
    with pytest.raises(FormatError, match="Allowed is 0 to 10000 ms"):
        read_events(path, sort_within_us=window_us)
