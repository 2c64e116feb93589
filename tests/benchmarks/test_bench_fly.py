"""CPU time of the fly detector for 2 M events: all of it, and parts of it."""

from time import process_time

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from detector.event_checks import check_chunk
from detector.fly.detector import FlyConfig, FlyDetector
from detector.fly.saturating_surface import SaturatingSurfaces
from detector.fly.time_surface import TimeSurfaces
from flybench.events import EVENT_DTYPE, Events

EVENTS = 2_000_000


def moving_block() -> Events:
    """2 M events in 1 s: a textured block of 120×60 px that moves at 500 px/s, and noise."""
    rng = np.random.default_rng(0)
    events = np.zeros(EVENTS, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, 1_000_000, EVENTS))
    left = (events["t"] * 500e-6).astype(np.int64)
    events["x"] = (left + rng.integers(0, 120, EVENTS)) % 346
    events["y"] = 100 + rng.integers(0, 60, EVENTS)
    noisy = rng.random(EVENTS) < 0.2
    events["x"][noisy] = rng.integers(0, 346, noisy.sum())
    events["y"][noisy] = rng.integers(0, 260, noisy.sum())
    events["p"] = rng.random(EVENTS) < 0.5
    return events


@pytest.mark.benchmark(group="2 M events and 100 estimates, by chunk [CPU]", timer=process_time)
@pytest.mark.parametrize("chunk", [100, 1_000, 10_000, 100_000, 1_000_000])
def test_push(benchmark: BenchmarkFixture, chunk: int) -> None:
    """All stages through `push`, with one estimate per hop."""
    events = moving_block()
    FlyDetector().push(events[:20_000])

    def run() -> None:
        fly = FlyDetector()
        for start in range(0, EVENTS, chunk):
            fly.push(events[start : start + chunk])

    benchmark(run)


@pytest.mark.benchmark(
    group="2 M events accumulated without estimates, by chunk [CPU]", timer=process_time
)
@pytest.mark.parametrize("preset", ["paper", "robust"])
@pytest.mark.parametrize("chunk", [100, 1_000, 10_000, 100_000, 1_000_000])
def test_accumulation(benchmark: BenchmarkFixture, chunk: int, preset: str) -> None:
    """Event checks and time surfaces, without estimates; those of `wide` are the paper's."""
    events, config = moving_block(), FlyConfig.preset(preset)
    kind = SaturatingSurfaces if preset == "robust" else TimeSurfaces
    chunks = [events[start : start + chunk] for start in range(0, EVENTS, chunk)]

    def run() -> None:
        surfaces: SaturatingSurfaces | TimeSurfaces = kind(config, width=346, height=260)
        hop = 0
        for part in chunks:
            check_chunk(part, width=346, height=260, now_us=surfaces.last_event_us)
            taken = 0
            while True:
                until_us = (hop + 1) * config.hop_us
                taken = surfaces.accumulate(part, taken, until_us=until_us)
                if taken == part.size:
                    break
                hop += 1
                surfaces.begin_hop(hop)

    run()
    benchmark(run)


@pytest.mark.benchmark(
    group="one estimate, stages that process the whole image [CPU]", timer=process_time
)
@pytest.mark.parametrize("preset", ["paper", "wide", "robust"])
def test_estimate(benchmark: BenchmarkFixture, preset: str) -> None:
    """Averages, T4/T5, attention and tangential cells of one estimate."""
    events = moving_block()
    first = events[events["t"] < 200_000]

    def after_first_events() -> tuple[tuple[FlyDetector], dict[str, int]]:
        fly = FlyDetector(FlyConfig.preset(preset))
        fly.push(first)
        return (fly,), {"t_us": 200_000}

    assert len(FlyDetector.advance(*after_first_events()[0], t_us=200_000)) == 1
    benchmark.pedantic(FlyDetector.advance, setup=after_first_events, rounds=50)  # type: ignore[no-untyped-call]
