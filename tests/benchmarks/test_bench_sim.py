"""CPU time of rendering: a full frame, a sample from keyframes, and a whole crossing."""

import itertools
from collections.abc import Sequence
from pathlib import Path
from time import process_time
from typing import Any

import pytest

from sim import Crossing, CrossingConfig, Lighting, LuminanceCache
from sim.config import PAPER_OMEGA_RAD_S
from sim.render.kept_renderer import kept_renderer


@pytest.fixture(params=list(Lighting))
def crossing(request: pytest.FixtureRequest) -> Crossing:
    return Crossing(CrossingConfig(lighting=request.param))


@pytest.mark.benchmark(
    group="a full luminance frame, 346×260, 2×2 [CPU]", timer=process_time, min_rounds=10
)
def test_full_frame(benchmark: Any, crossing: Crossing) -> None:
    with crossing.full_frame_renderer(2) as render:
        times = itertools.count(crossing.duration_us // 2, 1_000)
        render(0)
        benchmark(lambda: render(next(times)))


@pytest.mark.benchmark(group="a sample of the crossing with ground truth [CPU]", timer=process_time)
def test_sample(benchmark: Any, crossing: Crossing) -> None:
    times_us = crossing.times_us()
    samples = crossing.samples(times_us[len(times_us) // 2 :])
    benchmark.pedantic(lambda: next(samples), rounds=100, warmup_rounds=3)


@pytest.mark.benchmark(group="a whole crossing with ground truth, renderer set-up included [CPU]")
@pytest.mark.parametrize(
    ("lighting", "omega_rad_s"),
    [(lighting, omega) for lighting, omegas in PAPER_OMEGA_RAD_S.items() for omega in omegas],
)
def test_crossing_against_full_frames(
    benchmark: Any, capsys: pytest.CaptureFixture[str], lighting: Lighting, omega_rad_s: float
) -> None:
    """Full frames at some of the sample times, rendered before and after, give the reference."""
    crossing = Crossing(CrossingConfig(lighting=lighting, omega_rad_s=omega_rad_s))
    times_us = crossing.times_us()
    some_us = times_us[len(times_us) // 32 :: len(times_us) // 16]

    def run() -> tuple[float, float]:
        before_s = full_frame_cpu_s(crossing, some_us[::2])
        start = process_time()
        count = sum(1 for _ in crossing.samples())
        spent_s = process_time() - start
        full_s = (before_s + full_frame_cpu_s(crossing, some_us[1::2])) / 2
        assert count == len(times_us)
        return count * full_s / spent_s, spent_s

    ratio, spent_s = benchmark.pedantic(run, rounds=1)
    seconds = spent_s / (crossing.duration_us * 1e-6)
    benchmark.extra_info["times_less_than_full_frames"] = ratio
    with capsys.disabled():
        print(
            f"\n{lighting} {omega_rad_s} rad/s: {len(times_us)} samples in {spent_s:.1f} s of CPU,"
            f" {ratio:.1f} times less than full 2×2 frames; {seconds:.1f} s per second of scene"
        )


@pytest.mark.benchmark(group="a crossing of a sweep over speeds, with ground truth [CPU]")
@pytest.mark.parametrize(
    ("lighting", "omega_rad_s"), [(Lighting.DAY, 1.61), (Lighting.NIGHT, 1.42)]
)
def test_crossing_of_a_sweep(
    benchmark: Any, tmp_path: Path, lighting: Lighting, omega_rad_s: float
) -> None:
    """Background and renderer are those of a crossing at another speed, and luminance is stored."""

    def run(omega_rad_s: float) -> float:
        config = CrossingConfig(lighting=lighting, omega_rad_s=omega_rad_s)
        start = process_time()
        crossing = Crossing(config, cache=LuminanceCache(tmp_path))
        assert sum(1 for _ in crossing.samples()) > 1000
        return (process_time() - start) / (crossing.duration_us * 1e-6)

    with kept_renderer():
        run(2 * omega_rad_s)
        per_s = benchmark.pedantic(run, (omega_rad_s,), rounds=1)
    benchmark.extra_info["cpu_s_per_second_of_scene"] = round(per_s, 2)


def full_frame_cpu_s(crossing: Crossing, times_us: Sequence[int]) -> float:
    """Mean CPU time of a full frame, without setting up the renderer [s]."""
    with crossing.full_frame_renderer(2) as render:
        render(0)
        start = process_time()
        for t_us in times_us:
            render(t_us)
        return (process_time() - start) / len(times_us)
