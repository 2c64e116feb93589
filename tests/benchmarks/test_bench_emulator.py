"""Cost of the emulator: a textured vehicle that crosses at 600 px/s, sampled at 1 kHz.

CPU time of one thread, by day and by night, with all noise and with none; what a caller saves who
knows where the light changes; the cost by pixels, up to 1280×720; wall time of one and two
threads, which wants two idle cores; and, beside the times, bytes of state a pixel.
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
"""Rows and columns [px]: a car of 4 m by 1.5 m seen from 8 m through a 6 mm lens."""

Frame = npt.NDArray[np.float32]
Window = tuple[int, int, int, int]
Sample = tuple[int, Frame, Window]


def texture(shape: tuple[int, int], blur_px: float, seed: int) -> Frame:
    """Blurred noise between 0.1 and 0.9."""
    grain = np.random.default_rng(seed).random(shape, np.float32)
    soft = cv2.GaussianBlur(grain, (0, 0), blur_px)
    return np.asarray(0.1 + 0.8 * (soft - soft.min()) / np.ptp(soft), np.float32)


def crossing_windows(
    level_cd_m2: float, shape: tuple[int, int] = (260, 346), frames: int = FRAMES
) -> Iterator[Sample]:
    """A vehicle that slides over a still background by 0.6 px a frame, and where it does.

    Its size is in proportion to the sensor's.
    """
    street = texture(shape, 2.0, 1)
    rows, columns = VEHICLE[0] * shape[0] // 260, VEHICLE[1] * shape[1] // 346
    top = 100 * shape[0] // 260
    vehicle = texture((rows, columns + 1), 1.5, 2)
    for k in range(frames):
        x = 20.0 + 0.6 * k
        left, share = int(x), np.float32(x - int(x))
        frame = street.copy()
        shifted = share * vehicle[:, :-1] + (1 - share) * vehicle[:, 1:]
        frame[top : top + rows, left : left + columns] = shifted
        window = (left - 1, top, left + columns, top + rows)
        yield k * 1000, (level_cd_m2 * frame).astype(np.float32), window


def crossing(level_cd_m2: float) -> Iterator[tuple[int, Frame]]:
    """The vehicle by itself: times and frames."""
    for t_us, frame, _ in crossing_windows(level_cd_m2):
        yield t_us, frame


def measure(
    benchmark: BenchmarkFixture,
    config: SensorConfig,
    samples: list[Sample],
    *,
    threads: int = 1,
    hint: bool = False,
) -> None:
    """Time the frames after the first five of a crossing, and note the bytes of state a pixel."""

    def step(sensor: EventSensor, sample: Sample) -> int:
        t_us, frame, window = sample
        return sensor.step(t_us, frame, changed=window if hint else None).events.size

    def settled() -> tuple[tuple[EventSensor], dict[str, object]]:
        sensor = EventSensor(config, seed=1, threads=threads)
        for sample in samples[:5]:
            step(sensor, sample)
        assert sensor._state is not None
        held = sum(array.nbytes for array in sensor._state)
        benchmark.extra_info["bytes a pixel"] = round(held / (config.width * config.height), 1)
        return (sensor,), {}

    def run(sensor: EventSensor) -> int:
        return sum(step(sensor, sample) for sample in samples[5:])

    pedantic: Callable[..., int] = benchmark.pedantic
    assert pedantic(run, setup=settled, rounds=5, warmup_rounds=1) > 0


@pytest.mark.benchmark(
    group=f"{FRAMES - 5} frames through the sensor, 346×260, 1 kHz [CPU]", timer=process_time
)
@pytest.mark.parametrize("level_cd_m2", [1000.0, 1.0], ids=["day", "night"])
@pytest.mark.parametrize("kind", ["noisy", "noise_free", "noisy_with_window"])
def test_vehicle_crossing(benchmark: BenchmarkFixture, level_cd_m2: float, kind: str) -> None:
    config = SensorConfig.noise_free() if kind == "noise_free" else SensorConfig()
    samples = list(crossing_windows(level_cd_m2))
    measure(benchmark, config, samples, hint=kind == "noisy_with_window")


@pytest.mark.benchmark(
    group=f"{FRAMES - 5} frames of a still scene, 346×260, 1 kHz [CPU]", timer=process_time
)
@pytest.mark.parametrize("level_cd_m2", [1000.0, 1.0], ids=["day", "night"])
def test_still_scene(benchmark: BenchmarkFixture, level_cd_m2: float) -> None:
    _, frame, _ = next(crossing_windows(level_cd_m2))
    samples = [(k * 1000, frame, (0, 0, 0, 0)) for k in range(FRAMES)]
    measure(benchmark, SensorConfig(), samples)


@pytest.mark.benchmark(group="45 frames of 1280×720, 1 kHz [CPU]", timer=process_time)
@pytest.mark.parametrize("level_cd_m2", [1000.0, 1.0], ids=["day", "night"])
def test_more_pixels(benchmark: BenchmarkFixture, level_cd_m2: float) -> None:
    """10.2 times the pixels of 346×260: compare a frame with 1/195 of the crossing's time."""
    samples = list(crossing_windows(level_cd_m2, (720, 1280), 50))
    measure(benchmark, SensorConfig(width=1280, height=720), samples)


@pytest.mark.benchmark(group="45 frames of 1280×720, 1 kHz, by threads [wall]", timer=perf_counter)
@pytest.mark.parametrize("threads", [1, 2])
def test_threads(benchmark: BenchmarkFixture, threads: int) -> None:
    samples = list(crossing_windows(1000.0, (720, 1280), 50))
    measure(benchmark, SensorConfig(width=1280, height=720), samples, threads=threads)


@pytest.mark.benchmark(
    group=f"{FRAMES - 5} frames through the sensor, 346×260, by threads [wall]", timer=perf_counter
)
@pytest.mark.parametrize("threads", [1, 2])
def test_threads_on_few_pixels(benchmark: BenchmarkFixture, threads: int) -> None:
    measure(benchmark, SensorConfig(), list(crossing_windows(1000.0)), threads=threads)
