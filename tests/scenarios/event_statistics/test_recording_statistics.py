import tracemalloc

import numpy as np
import pytest

from emulator import ApsFrame
from flybench.events import Events, empty_events
from flybench.memory import MemoryBudgetError, free_bytes
from formats import Chunk
from scenarios.event_statistics.recording_statistics import (
    RecordingStatistics,
    StatisticsCollector,
    statistics_of,
)
from tests.scenarios.event_statistics.made_events import SIZE, edge_events, events_of, noise_events


def statistics(*blocks: Events) -> RecordingStatistics:
    return statistics_of([Chunk(block) for block in blocks], **SIZE)


def test_an_edge_of_four_events() -> None:
    found = statistics(edge_events(px_s=400.0, events_each=4, apart_us=2000))
    assert found.events_an_edge == 4.0
    assert found.single_event_edges == 0.0
    assert found.edges == 32 * 24
    assert found.with_predecessor == 0.75
    assert found.on_share == 1.0
    assert found.alternation == 0.0
    assert found.interval_us(0.01) == pytest.approx(2000, rel=0.01)
    assert found.quiet_share == 0.0
    assert found.quiet_alternation is None


def test_noise() -> None:
    found = statistics(noise_events(5.0, 2_000_000))
    assert found.on_share == pytest.approx(0.5, abs=0.01)
    assert found.alternation == pytest.approx(0.5, abs=0.01)
    assert found.with_predecessor == pytest.approx(1 - np.exp(-5.0 * 0.03), abs=0.01)
    assert found.interval_us(0.5) == pytest.approx(np.log(2) / 10.0 * 1e6, rel=0.05)
    assert found.noise[0].on_hz == pytest.approx(5.0, rel=0.05)
    assert found.noise[0].spread == pytest.approx(0.0, abs=0.1)
    assert found.rate_hz == pytest.approx(10.0, rel=0.03)


def test_frames_split_the_noise_by_brightness() -> None:
    image = np.full((24, 32), 100, np.uint16)
    image[:, 16:] = 0
    chunk = Chunk(noise_events(2.0, 1_000_000), (ApsFrame(0, 10, image),))
    found = statistics_of([chunk], **SIZE)
    assert found.frames == 1
    assert len(found.noise) > 2
    assert {n.from_brightness for n in found.noise if n.pixels} == {None, 0.0, 2.0}


def test_blocks_change_nothing_and_empty_ones_are_allowed() -> None:
    stream = noise_events(5.0, 300_000)
    whole = statistics(stream)
    parts = statistics(empty_events(), *np.array_split(stream, 7))
    assert whole.noise == parts.noise
    assert whole.readout == parts.readout
    assert whole.span_us == parts.span_us


def test_one_event_has_no_intervals() -> None:
    found = statistics(events_of((7, 1, 1, 1)))
    assert found.interval_us(0.5) is found.alternation is found.events_an_edge is None
    assert found.events == found.span_us == 1


def test_a_sensor_beyond_the_memory_budget_is_refused_before_anything_is_allocated() -> None:
    with pytest.raises(MemoryBudgetError, match="recordings of 30000×30000 px needs 135 GB"):
        StatisticsCollector(width=30_000, height=30_000)


def test_the_counted_memory_covers_all_that_is_allocated() -> None:
    before, side = free_bytes(), 1000
    image = np.ones((side, side), np.uint16)
    tracemalloc.start()
    collector = StatisticsCollector(width=side, height=side)
    counted = before - free_bytes()
    collector.add(Chunk(noise_events(5.0, 20_000), (ApsFrame(0, 10, image),)))
    collector.result()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert 0.9 * counted < peak < 1.02 * counted
    del collector
    assert free_bytes() == before
