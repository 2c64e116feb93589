"""Cost of the emulator for a textured vehicle that crosses at 600 px/s, sampled at 1 kHz.

The benchmarks measure the CPU time of one thread by day and by night, with and without noise, with
and without the rectangle in which the luminance changes, for a static scene, and for 1280×720
pixels. They also measure the wall time of one and of two threads, for which two cores must be idle.
Each benchmark also records the bytes of state per pixel.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import perf_counter, process_time

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from emulator import EventSensor, SensorConfig

FRAMES = 200
VEHICLE = (60, 160)
"""Rows and columns of the vehicle [px]: 4 m by 1.5 m seen from 8 m through a 6 mm lens."""

Frame = npt.NDArray[np.float32]
Rectangle = tuple[int, int, int, int]
Sample = tuple[int, Frame, Rectangle]


def texture(shape: tuple[int, int], blur_px: float, seed: int) -> Frame:
    """Return blurred noise between 0.1 and 0.9."""
    noise = np.random.default_rng(seed).random(shape, np.float32)
    blurred = cv2.GaussianBlur(noise, (0, 0), blur_px)
    return np.asarray(0.1 + 0.8 * (blurred - blurred.min()) / np.ptp(blurred), np.float32)


def vehicle_samples(
    level_cd_m2: float, shape: tuple[int, int] = (260, 346), frames: int = FRAMES
) -> Iterator[Sample]:
    """Yield frames of a vehicle that moves over a static background by 0.6 px a frame.

    The size of the vehicle is proportional to that of the sensor. Each sample also has the
    rectangle in which the luminance may have changed.
    """
    background = texture(shape, 2.0, 1)
    rows, columns = VEHICLE[0] * shape[0] // 260, VEHICLE[1] * shape[1] // 346
    top = 100 * shape[0] // 260
    vehicle = texture((rows, columns + 1), 1.5, 2)
    for k in range(frames):
        x = 20.0 + 0.6 * k
        left, fraction = int(x), np.float32(x - int(x))
        frame = background.copy()
        shifted = fraction * vehicle[:, :-1] + (1 - fraction) * vehicle[:, 1:]
        frame[top : top + rows, left : left + columns] = shifted
        changed = (left - 1, top, left + columns, top + rows)
        yield k * 1000, (level_cd_m2 * frame).astype(np.float32), changed


def measure(
    benchmark: BenchmarkFixture,
    config: SensorConfig,
    samples: list[Sample],
    *,
    threads: int = 1,
    pass_changed: bool = False,
) -> None:
    """Time the frames after the first five, and record the bytes of state per pixel.

    Args:
        benchmark: pytest-benchmark's fixture.
        config: configuration of the sensor.
        samples: time, frame and changed rectangle of each sample.
        threads: threads that share a step of the sensor.
        pass_changed: True to tell the sensor in which rectangle the luminance may have changed.
    """

    def step(sensor: EventSensor, sample: Sample) -> int:
        t_us, frame, changed = sample
        return sensor.step(t_us, frame, changed=changed if pass_changed else None).events.size

    def after_five_frames() -> tuple[tuple[EventSensor], dict[str, object]]:
        sensor = EventSensor(config, seed=1, threads=threads)
        for sample in samples[:5]:
            step(sensor, sample)
        assert sensor._state is not None
        state_bytes = sum(array.nbytes for array in sensor._state)
        benchmark.extra_info["bytes per pixel"] = round(
            state_bytes / (config.width * config.height), 1
        )
        return (sensor,), {}

    def run(sensor: EventSensor) -> int:
        return sum(step(sensor, sample) for sample in samples[5:])

    pedantic: Callable[..., int] = benchmark.pedantic
    assert pedantic(run, setup=after_five_frames, rounds=5, warmup_rounds=1) > 0


@pytest.mark.benchmark(
    group=f"{FRAMES - 5} frames through the sensor, 346×260, 1 kHz [CPU]", timer=process_time
)
@pytest.mark.parametrize("level_cd_m2", [1000.0, 1.0], ids=["day", "night"])
@pytest.mark.parametrize("kind", ["noisy", "noise_free", "noisy_with_changed_rectangle"])
def test_vehicle_crossing(benchmark: BenchmarkFixture, level_cd_m2: float, kind: str) -> None:
    config = SensorConfig.noise_free() if kind == "noise_free" else SensorConfig()
    samples = list(vehicle_samples(level_cd_m2))
    measure(benchmark, config, samples, pass_changed=kind == "noisy_with_changed_rectangle")


@pytest.mark.benchmark(
    group=f"{FRAMES - 5} frames of a static scene, 346×260, 1 kHz [CPU]", timer=process_time
)
@pytest.mark.parametrize("level_cd_m2", [1000.0, 1.0], ids=["day", "night"])
def test_static_scene(benchmark: BenchmarkFixture, level_cd_m2: float) -> None:
    _, frame, _ = next(vehicle_samples(level_cd_m2))
    samples = [(k * 1000, frame, (0, 0, 0, 0)) for k in range(FRAMES)]
    measure(benchmark, SensorConfig(), samples)


@pytest.mark.benchmark(group="45 frames of 1280×720, 1 kHz [CPU]", timer=process_time)
@pytest.mark.parametrize("level_cd_m2", [1000.0, 1.0], ids=["day", "night"])
def test_more_pixels(benchmark: BenchmarkFixture, level_cd_m2: float) -> None:
    """10.2 times the pixels of 346×260; a frame compares with 1/195 of the crossing's time."""
    samples = list(vehicle_samples(level_cd_m2, (720, 1280), 50))
    measure(benchmark, SensorConfig(width=1280, height=720), samples)


@pytest.mark.benchmark(group="45 frames of 1280×720, 1 kHz, by threads [wall]", timer=perf_counter)
@pytest.mark.parametrize("threads", [1, 2])
def test_threads(benchmark: BenchmarkFixture, threads: int) -> None:
    samples = list(vehicle_samples(1000.0, (720, 1280), 50))
    measure(benchmark, SensorConfig(width=1280, height=720), samples, threads=threads)


@pytest.mark.benchmark(
    group=f"{FRAMES - 5} frames through the sensor, 346×260, by threads [wall]", timer=perf_counter
)
@pytest.mark.parametrize("threads", [1, 2])
def test_threads_on_few_pixels(benchmark: BenchmarkFixture, threads: int) -> None:
    measure(benchmark, SensorConfig(), list(vehicle_samples(1000.0)), threads=threads)
