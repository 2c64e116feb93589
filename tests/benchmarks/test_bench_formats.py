"""CPU time to read and to write a recording of 10 M events.

Reading uses two processes; their CPU times are added up.
"""

import resource
from itertools import count
from pathlib import Path
from time import process_time

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from detector.fly.detector import FlyDetector
from flybench.events import EVENT_DTYPE, Events
from formats import open_events, write_events
from tests.benchmarks.test_bench_fly import moving_block

REPEATS = 5


def cpu_with_children_s() -> float:
    """CPU time of this process and of its child processes that have ended [s]."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return process_time() + children.ru_utime + children.ru_stime


@pytest.fixture(scope="module")
def events() -> Events:
    """10 M events in 5 s: one second of a moving block and noise, repeated five times."""
    second = moving_block()
    parts = np.concatenate([second] * REPEATS).astype(EVENT_DTYPE)
    parts["t"] += np.repeat(np.arange(REPEATS) * 1_000_000, second.size)
    return parts


@pytest.mark.benchmark(
    group="10 M events read and detected in one pass [CPU]", timer=cpu_with_children_s
)
@pytest.mark.parametrize("ending", ["aedat4", "h5", "mcap"])
def test_reading_and_detecting(
    benchmark: BenchmarkFixture, tmp_path: Path, events: Events, ending: str
) -> None:
    """Required: 5 M events/s or more, which is 2 s or less."""
    path = tmp_path / f"events.{ending}"
    write_events(path, [events], width=346, height=260)
    FlyDetector().push(events[:20_000])

    def run() -> int:
        fly = FlyDetector()
        with open_events(path) as file:
            for chunk in file:
                fly.push(chunk.events)
            return file.statistics.events

    assert benchmark.pedantic(run, rounds=3) == events.size  # type: ignore[no-untyped-call]


@pytest.mark.benchmark(group="10 M events written [CPU]", timer=process_time)
@pytest.mark.parametrize("ending", ["aedat4", "h5", "raw", "txt", "csv", "npz"])
def test_writing(benchmark: BenchmarkFixture, tmp_path: Path, events: Events, ending: str) -> None:
    """Required: 2 M events/s or more, which is 5 s or less."""
    numbers = count()

    def run() -> None:
        write_events(
            tmp_path / f"{next(numbers)}.{ending}", np.split(events, 100), width=346, height=260
        )

    benchmark.pedantic(run, rounds=3)  # type: ignore[no-untyped-call]
