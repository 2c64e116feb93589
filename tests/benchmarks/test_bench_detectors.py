"""CPU time of the detectors on equal events, and the errors of those that give a velocity.

The events of the velocity benchmarks are 20 000 in 50 ms. With the package eventcv installed, its
contrast maximisation is measured for comparison with flybench's; without it that benchmark is
skipped.
"""

import math
from time import process_time

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from detector.contrast_maximisation.detector import (
    ContrastConfig,
    ContrastMaximisation,
    Reward,
    maximise_contrast,
)
from detector.contrast_maximisation.edge_informed import EdgeInformedConfig, EdgeInformedContrast
from detector.estimate import Detector
from detector.fly.detector import FlyDetector
from detector.frame_fly.detector import FrameFly, FrameFlyConfig
from detector.plane_fit.detector import PlaneFit
from detector.space_time_filters.detector import SpaceTimeFilters
from detector.spiking_delays.detector import SpikingDelays
from detector.time_difference.detector import TimeDifference
from flybench.direction import Direction
from tests.detector.moving_dots import WINDOW_US, dots
from tests.detector.test_operating_range import passing

WINDOW = "one velocity from 20 000 events in 50 ms [CPU]"
SPEEDS_PX_S = [120.0, 500.0, 1000.0]


def true_velocity_px_s(speed_px_s: float) -> tuple[float, float]:
    return speed_px_s * math.cos(0.3), speed_px_s * math.sin(0.3)


def record_error(benchmark: BenchmarkFixture, estimate: object, speed_px_s: float) -> None:
    error = np.subtract(np.asarray(estimate, np.float64), true_velocity_px_s(speed_px_s))
    benchmark.extra_info["error_px_s"] = round(float(np.hypot(*error)), 2)


@pytest.mark.benchmark(group=WINDOW, timer=process_time)
@pytest.mark.parametrize("speed_px_s", SPEEDS_PX_S)
@pytest.mark.parametrize("reward", Reward, ids=lambda r: r.name.lower())
@pytest.mark.parametrize("is_cold", [True, False], ids=["cold", "warm"])
def test_contrast_maximisation(
    benchmark: BenchmarkFixture, is_cold: bool, reward: Reward, speed_px_s: float
) -> None:
    """flybench's, without a start value or from one that is 7 % and 20 px/s off."""
    events = dots(true_velocity_px_s(speed_px_s), seed=int(speed_px_s))
    vx, vy = true_velocity_px_s(speed_px_s)
    start = None if is_cold else (0.93 * vx + 20.0, 0.93 * vy - 20.0)
    config = ContrastConfig(reward=reward)

    def run() -> tuple[float, float]:
        estimate = maximise_contrast(
            events, from_us=0, to_us=WINDOW_US, width=346, height=260, config=config, start=start
        )
        assert estimate is not None
        return estimate.velocity_px_s

    run()
    record_error(benchmark, benchmark(run), speed_px_s)


@pytest.mark.benchmark(group=WINDOW, timer=process_time)
@pytest.mark.parametrize("speed_px_s", SPEEDS_PX_S)
def test_eventcv(benchmark: BenchmarkFixture, speed_px_s: float) -> None:
    """eventcv's with its defaults: it starts at velocity 0 and maximises the variance."""
    eventcv = pytest.importorskip("eventcv")
    events = dots(true_velocity_px_s(speed_px_s), seed=int(speed_px_s))
    columns = np.stack([events[name].astype(np.int64) for name in "xytp"], axis=1)
    stream = eventcv.from_numpy(columns, sensor_size=(346, 260), time_unit="us")
    velocity = benchmark(lambda: stream.contrast_maximise()["params"])
    record_error(benchmark, velocity, speed_px_s)


@pytest.mark.benchmark(group="a crossing with an estimate every 10 ms [CPU]", timer=process_time)
@pytest.mark.parametrize(
    "make",
    [
        FlyDetector,
        ContrastMaximisation,
        PlaneFit,
        SpaceTimeFilters,
        SpikingDelays,
        TimeDifference,
    ],
)
def test_detectors(benchmark: BenchmarkFixture, make: type[Detector]) -> None:
    """The event-based detectors on one stream: 500 px/s, noise of 1 Hz per pixel."""
    events, until_us = passing(500, Direction.RIGHT, noise_hz=1.0)
    benchmark.extra_info["events"] = int(events.size)
    benchmark.extra_info["estimates"] = until_us // 10_000

    def run() -> None:
        detector = make()
        detector.push(events)
        detector.advance(until_us)

    run()
    benchmark(run)


@pytest.mark.benchmark(group="edge-informed, 100 ms with frames at 40 Hz [CPU]", timer=process_time)
def test_edge_informed(benchmark: BenchmarkFixture) -> None:
    """Edge-informed contrast maximisation with windows of 50 ms, and frames of random blocks."""
    events, _ = passing(500, Direction.RIGHT, noise_hz=1.0)
    events = events[events["t"] < 100_000]
    blocks = np.random.default_rng(0).integers(0, 1024, (13, 17)).astype(np.uint16)
    frame = np.kron(blocks, np.ones((20, 21), np.uint16))[:260, :346].copy()

    def run() -> None:
        detector = EdgeInformedContrast(EdgeInformedConfig(hop_us=50_000))
        for t_us in range(25_000, 100_001, 25_000):
            detector.push(events[(events["t"] >= t_us - 25_000) & (events["t"] < t_us)])
            detector.push_frame(t_us, frame)

    run()
    benchmark(run)


@pytest.mark.benchmark(group="one APS frame [CPU]", timer=process_time)
@pytest.mark.parametrize("preset", ["published", "coarse"])
def test_frame_fly(benchmark: BenchmarkFixture, preset: str) -> None:
    """The frame-based fly detector on frames of 346×260 px."""
    rng = np.random.default_rng(0)
    images = [rng.integers(0, 1024, (260, 346)).astype(np.uint16) for _ in range(2)]
    fly = FrameFly(FrameFlyConfig.preset(preset))
    frame = 0

    def run() -> None:
        nonlocal frame
        fly.push_frame(frame * 25_000, images[frame % 2])
        frame += 1

    benchmark(run)
