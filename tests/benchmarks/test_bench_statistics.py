"""CPU time of the statistics that `flybench compare` counts."""

from time import process_time

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from flybench.events import EVENT_DTYPE
from formats import Chunk
from scenarios.event_statistics.recording_statistics import statistics_of
from tests.benchmarks.test_bench_fly import moving_block


@pytest.mark.benchmark(group="2 M events, all statistics [CPU]", timer=process_time)
def test_statistics(benchmark: BenchmarkFixture) -> None:
    """Required: 5 M events/s or more, which is 0.4 s or less."""
    events = moving_block().astype(EVENT_DTYPE)
    chunks = [Chunk(part) for part in np.array_split(events, 40)]

    def run() -> int:
        return statistics_of(chunks, width=346, height=260).events

    run()  # compiles
    assert benchmark.pedantic(run, rounds=3) == events.size  # type: ignore[no-untyped-call]
