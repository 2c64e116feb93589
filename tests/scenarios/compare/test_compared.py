import numpy as np
import pytest

from emulator import ApsFrame
from flybench.events import EVENT_DTYPE, Events
from formats import Chunk
from scenarios.compare.compared import Compared, busiest_shared, compare_statistics
from scenarios.event_statistics.recording_statistics import RecordingStatistics, statistics_of
from tests.scenarios.event_statistics.made_events import SIZE, edge_events, noise_events


def statistics(events: Events, *frames: ApsFrame) -> RecordingStatistics:
    return statistics_of([Chunk(events, frames)], **SIZE)


def by_key(a: RecordingStatistics, b: RecordingStatistics) -> dict[str, Compared]:
    rows = compare_statistics(a, b)
    found = {row.key: row for row in rows}
    assert len(found) == len(rows)
    assert len({row.name for row in rows}) == len(rows)
    return found


def sweeping(rows: list[int]) -> Events:
    events = np.zeros(3000, EVENT_DTYPE)
    events["t"] = np.arange(3000)
    events["y"] = np.resize(rows, 3000)
    return events


def test_a_recording_has_no_distance_to_itself() -> None:
    grey = ApsFrame(0, 10, np.arange(768, dtype=np.uint16).reshape(24, 32))
    found = statistics(noise_events(8.0, 1_000_000), grey)
    rows = by_key(found, found)
    assert {row.distance for row in rows.values()} <= {0.0, None}
    assert rows["noise_hz.from_0.5"].distance == 0.0


def test_an_emulator_with_twice_the_events_an_edge() -> None:
    real = statistics(edge_events(px_s=400.0, events_each=3))
    emulated = statistics(edge_events(px_s=400.0, events_each=6, apart_us=1000))
    rows = by_key(real, emulated)
    edge = rows["events_an_edge"]
    assert (edge.a, edge.b) == (3.0, 6.0)
    assert edge.distance == pytest.approx(np.log(2))
    assert rows["with_predecessor"].distance == pytest.approx(5 / 6 - 2 / 3)
    assert rows["intervals"].distance == pytest.approx(np.log(2), rel=0.02)
    assert rows["noise_hz.quiet"].distance is None  # no pixel is quiet


def test_an_emulator_with_ten_times_the_noise() -> None:
    real, emulated = (statistics(noise_events(rate, 2_000_000)) for rate in (0.5, 5.0))
    rows = by_key(real, emulated)
    assert rows["noise_hz.quiet"].distance == pytest.approx(np.log(10), rel=0.05)
    assert rows["on_share"].distance == pytest.approx(0.0, abs=0.05)


def test_a_sweep_of_the_rows_is_told_from_an_arbitrary_order() -> None:
    rng = np.random.default_rng(0)
    real = statistics(sweeping(rng.integers(0, 24, 3000).tolist()))
    emulated = statistics(sweeping(list(range(24))))
    rows = by_key(real, emulated)
    assert rows["readout.down"].b == pytest.approx(23 / 24, abs=0.01)
    assert rows["readout.down"].distance == pytest.approx(23 / 24 - 0.5, abs=0.05)


def test_the_order_of_rows_is_not_compared_at_different_event_rates() -> None:
    slow = sweeping(list(range(24)))
    slow["t"] *= 100
    a, b = statistics(slow), statistics(sweeping(list(range(24))))
    assert busiest_shared(a, b) is None
    row = by_key(a, b)["readout.down"]
    assert row.distance is None
    assert row.a == pytest.approx(row.b)
