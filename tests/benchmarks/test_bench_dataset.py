"""CPU time and size of a sequence of a dataset with all labels, and of a sample for training."""

import time
from itertools import cycle
from pathlib import Path
from time import process_time

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from scenarios.dataset.plan import read_plan
from scenarios.dataset.run import run_dataset
from scenarios.dataset.sequence import make_sequence
from scenarios.datasets import EventDataset
from scenarios.pipeline.parallel import run_locally
from tests.scenarios.dataset.tiny import write_spec

SPEC = """
title = "Benchmark"
license = "CC0-1.0"
[splits]
train = 2
[[variants]]
name = "day"
crossing.lighting = "day"
[[variants]]
name = "night"
crossing.lighting = "night"
"""
CORES = 2


@pytest.fixture(scope="module")
def spec(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_spec(tmp_path_factory.mktemp("bench") / "spec.toml", SPEC)


@pytest.mark.benchmark(group="one sequence of a dataset with all labels [CPU]", timer=process_time)
@pytest.mark.parametrize("lighting", ["day", "night"])
def test_a_sequence(benchmark: BenchmarkFixture, spec: Path, tmp_path: Path, lighting: str) -> None:
    """The default crossing at 346×260 px. The cost of labels is relative to that of events."""
    plan = read_plan(spec).sequences[["day", "night"].index(lighting)]
    make_sequence(plan, tmp_path / "warm")
    start_s = time.process_time()
    cost = benchmark.pedantic(make_sequence, (plan, tmp_path / "out"), rounds=1)  # type: ignore[no-untyped-call]
    cpu_s = time.process_time() - start_s
    size = sum(path.stat().st_size for path in (tmp_path / "out").rglob("*") if path.is_file())
    benchmark.extra_info["labels_per_events"] = round(cost.labels_s / cost.events_s, 2)
    benchmark.extra_info["size_mb"] = round(size / 1e6, 1)
    benchmark.extra_info["sequences_per_hour_on_2_cores"] = round(CORES * 3600 / cpu_s)


@pytest.fixture(scope="module")
def dataset(spec: Path) -> Path:
    folder = spec.parent / "dataset"
    run_dataset(read_plan(spec), folder, lambda make, tasks: run_locally(make, tasks, jobs=1))
    return folder


@pytest.mark.benchmark(group="one sample of 50 ms with flow and motion [CPU]", timer=process_time)
@pytest.mark.parametrize("form", ["events", "voxel_grid", "time_surface"])
def test_a_sample(benchmark: BenchmarkFixture, dataset: Path, form: str) -> None:
    """One worker of a DataLoader; a time surface also reads the 50 ms before."""
    window_us = None if form == "time_surface" else 50_000
    samples = EventDataset(
        dataset,
        window_us=window_us,
        after=True,
        representation=form,
        bins=5,
        labels=["flow", "motion"],
    )

    numbers = cycle(range(len(samples)))
    for k in range(len(samples)):
        samples[k]
    benchmark(lambda: samples[next(numbers)])
