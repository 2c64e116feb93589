"""What a luminance frame costs: the whole image, and a sample that draws only what can change."""

import itertools
from collections.abc import Iterator
from time import process_time
from typing import Any

import pytest

from sim import Crossing, CrossingConfig, Lighting


@pytest.fixture(params=list(Lighting))
def crossing(request: pytest.FixtureRequest) -> Crossing:
    return Crossing(CrossingConfig(lighting=request.param))


@pytest.mark.benchmark(group="a whole luminance frame, 346×260, 2×2 [wall]", min_rounds=10)
def test_whole_frame(benchmark: Any, crossing: Crossing) -> None:
    with crossing.full_frames() as draw:
        times = itertools.count(crossing.duration_us // 2, 1_000)
        draw(0)
        benchmark(lambda: draw(next(times)))


@pytest.mark.benchmark(group="a sample of the crossing, truth included [CPU]", timer=process_time)
def test_sample(benchmark: Any, crossing: Crossing) -> None:
    samples = _in_the_middle(crossing)
    benchmark.pedantic(lambda: next(samples), rounds=40, warmup_rounds=2)


def _in_the_middle(crossing: Crossing) -> Iterator[Any]:
    """Samples from when the vehicle is wholly in view."""
    times = [t for t in crossing.times_us() if t >= crossing.duration_us // 2]
    crossing.times_us = lambda: times  # type: ignore[method-assign]
    return crossing.samples()
