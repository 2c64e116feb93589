"""Restore the order of events in time, or refuse the first that is late."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flybench.events import Events
from formats import FormatError, event_order, open_events, read_events
from formats.columns import PARSED_DTYPE, ParsedArray, ParsedFrame, ReadOptions
from formats.event_order import TimeOrder
from formats.samples import IMU_DTYPE, ParsedSamples
from tests.formats.evt3_words import evt3_words
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
                assert isinstance(events, np.ndarray)
                got += events["t"].tolist()
        for events in order.finish():
            assert isinstance(events, np.ndarray)
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


def in_words(items: Iterable[ParsedArray]) -> list[int | str]:
    words: list[int | str] = []
    for item in items:
        if isinstance(item, ParsedFrame):
            words.append(f"frame {item.start_us}")
        elif isinstance(item, ParsedSamples):
            words.append("samples")
        else:
            words += item["t"].tolist()
    return words


def test_frames_and_samples_wait_for_the_events_that_are_held() -> None:
    order = TimeOrder(PATH, ReadOptions(sort_within_us=10))
    image, samples = np.zeros((2, 2), np.uint16), ParsedSamples(np.zeros(1, IMU_DTYPE))
    got = in_words(order.push_other(ParsedFrame(0, 1, image)))
    got += in_words(order.push(at([2, 6, 5])))
    got += in_words(order.push_other(ParsedFrame(3, 6, image)))
    got += in_words(order.push_other(samples))
    assert got == ["frame 0"]
    got += in_words(order.push(at([9, 4, 25])))
    got += in_words(order.push_other(ParsedFrame(20, 25, image)))
    assert got == ["frame 0", 2, 4, 5, 6, "frame 3", "samples", 9]
    assert in_words(order.finish()) == [25, "frame 20"]


def test_more_frames_than_fit_into_memory_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(event_order, "_WAITING_MAX_BYTES", 15)
    order, image = TimeOrder(PATH, ReadOptions(sort_within_us=10)), np.zeros((2, 2), np.uint16)
    list(order.push(at([0])))
    for start_us in (1, 30, 60):
        list(order.push_other(ParsedFrame(start_us, start_us, image)))
        list(order.push(at([start_us + 20])))
    list(order.push_other(ParsedFrame(81, 81, image)))
    with pytest.raises(FormatError, match=r"MB of frames within 0\.01 ms.*shorter time"):
        list(order.push_other(ParsedFrame(82, 82, image)))


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
    "name", ["evt2.raw", "evt21.raw", "evt3.raw", "a.dat", "davis.aedat", "a.csv", "a.npy"]
)
def test_one_late_event_in_a_file(tmp_path: Path, name: str) -> None:
    events = random_events(2000)
    late = events.copy()
    late["t"][1000] = events["t"][999] - 40
    if name == "a.csv":  # flybench refuses to write such events
        path = tmp_path / name
        np.savetxt(path, np.stack([late[n] for n in "txyp"], 1), fmt="%d", delimiter=",")
    elif name == "evt3.raw":  # nor these
        path = tmp_path / name
        path.write_bytes(b"% evt 3.0\n% end\n" + evt3_words(late).tobytes())
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


@pytest.mark.parametrize(("late_us", "is_late"), [(1_000_000, True), (10_000_000, False)])
def test_evt3_steps_back_by_half_its_clock_are_overflows(
    tmp_path: Path, late_us: int, is_late: bool
) -> None:
    events, path = random_events(200), tmp_path / "a.raw"
    events["t"] += 12_000_000
    events["t"][100:] -= late_us
    path.write_bytes(b"% evt 3.0\n% end\n" + evt3_words(events).tobytes())
    if is_late:
        with pytest.raises(FormatError, match=r"event 100 has the time 110\d+ µs, after"):
            read_events(path, size=SIZE)
    else:
        events["t"][100:] += 1 << 24
        assert np.array_equal(read_events(path, size=SIZE), events)


@pytest.mark.parametrize("window_us", [-1, 10_000_001])
def test_a_wrong_window_is_refused(tmp_path: Path, window_us: int) -> None:
    path = make_file(tmp_path, "a.csv", random_events())
    with pytest.raises(FormatError, match="Allowed is 0 to 10000 ms"):
        read_events(path, sort_within_us=window_us)
