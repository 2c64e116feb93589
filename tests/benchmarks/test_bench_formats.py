"""Recordings in and out, in events a second: 10 M of them (`make bench`).

Figures are CPU time, of both processes where a file is read: what one core would take for all.
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
from tests.benchmarks.test_bench_detector import moving_clusters

REPEATS = 5


def cpu_of_both() -> float:
    """CPU time of this process and of those that it started and that have ended [s]."""
    others = resource.getrusage(resource.RUSAGE_CHILDREN)
    return process_time() + others.ru_utime + others.ru_stime


@pytest.fixture(scope="module")
def events() -> Events:
    """10 M events in 5 s: a second of a moving block and noise, five times."""
    second = moving_clusters()
    parts = np.concatenate([second] * REPEATS).astype(EVENT_DTYPE)
    parts["t"] += np.repeat(np.arange(REPEATS) * 1_000_000, second.size)
    return parts


@pytest.mark.benchmark(group="10 M events read and detected in one pass [CPU]", timer=cpu_of_both)
@pytest.mark.parametrize("ending", ["aedat4", "h5"])
def test_reading_and_detecting(
    benchmark: BenchmarkFixture, tmp_path: Path, events: Events, ending: str
) -> None:
    """To be 5 M events/s or better, so 2 s or less."""
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
    """To be 2 M events/s or better, so 5 s or less."""
    numbers = count()

    def run() -> None:
        write_events(
            tmp_path / f"{next(numbers)}.{ending}", np.split(events, 100), width=346, height=260
        )

    benchmark.pedantic(run, rounds=3)  # type: ignore[no-untyped-call]
