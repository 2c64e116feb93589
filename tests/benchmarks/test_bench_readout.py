"""Cost of the arbiter for 100 ms of random events on 346×260 pixels, in steps of 1 ms.

The tree of arbiters is compared with a readout in turn on the same events and the same bus, at a
low rate, at the rate that fills the bus with single events, and at one that fills it with lines.
"""

from __future__ import annotations

from collections.abc import Callable
from time import process_time

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from emulator import ReadoutConfig, ReadoutKind
from emulator.readout.arbiter import Arbiter
from emulator.readout.event_keys import TIME_SHIFT, Keys

WIDTH, HEIGHT = 346, 260
STEPS, STEP_US = 100, 1000


def random_events(rate_mev_s: float) -> list[Keys]:
    """Return the sorted keys of each step."""
    rng = np.random.default_rng(1)
    steps = []
    for number in rng.poisson(rate_mev_s * STEP_US, STEPS):
        times = rng.integers(1, STEP_US + 1, number)
        pixels = rng.integers(0, WIDTH * HEIGHT, number)
        steps.append(np.sort((times << TIME_SHIFT) | (pixels << 3)))
    return steps


@pytest.mark.benchmark(
    group="100 ms of random events through the arbiter [CPU]", timer=process_time
)
@pytest.mark.parametrize("rate_mev_s", [1.0, 4.0, 8.8])
@pytest.mark.parametrize("kind", [ReadoutKind.ROW_ARBITER, ReadoutKind.ROUND_ROBIN])
def test_arbiter(benchmark: BenchmarkFixture, kind: ReadoutKind, rate_mev_s: float) -> None:
    steps = random_events(rate_mev_s)
    benchmark.extra_info["events"] = sum(keys.size for keys in steps)

    def fresh() -> tuple[tuple[Arbiter], dict[str, object]]:
        config = ReadoutConfig(kind=kind)
        return (Arbiter(width=WIDTH, height=HEIGHT, config=config, refractory_us=3),), {}

    def run(arbiter: Arbiter) -> int:
        return sum(
            arbiter.read_out(keys, from_us=k * STEP_US, to_us=(k + 1) * STEP_US)[0].size
            for k, keys in enumerate(steps)
        )

    pedantic: Callable[..., int] = benchmark.pedantic
    assert pedantic(run, setup=fresh, rounds=5, warmup_rounds=1) > 0.9 * rate_mev_s * 1e5
