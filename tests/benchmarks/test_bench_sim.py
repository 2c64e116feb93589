"""What light costs: a whole frame, a sample from keyframes, and a crossing against full frames."""

import itertools
import statistics
from time import process_time
from typing import Any

import pytest

from sim import Crossing, CrossingConfig, Lighting
from sim.config import PAPER_OMEGA_RAD_S


@pytest.fixture(params=list(Lighting))
def crossing(request: pytest.FixtureRequest) -> Crossing:
    return Crossing(CrossingConfig(lighting=request.param))


@pytest.mark.benchmark(
    group="a whole luminance frame, 346×260, 2×2 [CPU]", timer=process_time, min_rounds=10
)
def test_whole_frame(benchmark: Any, crossing: Crossing) -> None:
    with crossing.full_frames(2) as draw:
        times = itertools.count(crossing.duration_us // 2, 1_000)
        draw(0)
        benchmark(lambda: draw(next(times)))


@pytest.mark.benchmark(group="a sample of the crossing, truth included [CPU]", timer=process_time)
def test_sample(benchmark: Any, crossing: Crossing) -> None:
    times_us = crossing.times_us()
    samples = crossing.samples(times_us[len(times_us) // 2 :])
    benchmark.pedantic(lambda: next(samples), rounds=100, warmup_rounds=3)


@pytest.mark.benchmark(group="a whole crossing, from nothing, truth included [CPU]")
@pytest.mark.parametrize(
    ("lighting", "omega_rad_s"),
    [(light, omega) for light, omegas in PAPER_OMEGA_RAD_S.items() for omega in omegas[1:3:2]],
)
def test_crossing_against_full_frames(
    benchmark: Any, capsys: pytest.CaptureFixture[str], lighting: Lighting, omega_rad_s: float
) -> None:
    crossing = Crossing(CrossingConfig(lighting=lighting, omega_rad_s=omega_rad_s))
    full_s = full_frame_cpu_s(crossing)

    def run() -> float:
        start = process_time()
        count = sum(1 for _ in crossing.samples())
        spent_s = process_time() - start
        ratio = count * full_s / spent_s
        seconds = spent_s / (crossing.duration_us * 1e-6)
        with capsys.disabled():
            print(
                f"\n{lighting} {omega_rad_s} rad/s: {count} samples in {spent_s:.1f} s of CPU, "
                f"{ratio:.1f} times less than 2×2 in full; {seconds:.1f} s a second of scene"
            )
        return ratio

    benchmark.extra_info["times_less_than_full_frames"] = benchmark.pedantic(run, rounds=1)


def full_frame_cpu_s(crossing: Crossing) -> float:
    """Median over the crossing."""
    spent = []
    with crossing.full_frames(2) as draw:
        draw(0)
        for k in range(1, 12):
            start = process_time()
            draw(k * crossing.duration_us // 12)
            spent.append(process_time() - start)
    return statistics.median(spent)
