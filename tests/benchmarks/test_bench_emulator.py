"""CPU time of the emulator: 346×260 at 1 kHz, a textured vehicle at 600 px/s, one thread."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import process_time

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from emulator import Davis346, SensorConfig

FRAMES = 200
VEHICLE = (60, 160)
"""Rows and columns [px]: a car of 4 m by 1.5 m seen from 8 m through a 6 mm lens."""

Frame = npt.NDArray[np.float32]


def texture(shape: tuple[int, int], blur_px: float, seed: int) -> Frame:
    """Blurred noise between 0.1 and 0.9."""
    grain = np.random.default_rng(seed).random(shape, np.float32)
    soft = cv2.GaussianBlur(grain, (0, 0), blur_px)
    return np.asarray(0.1 + 0.8 * (soft - soft.min()) / np.ptp(soft), np.float32)


def crossing(level_cd_m2: float) -> Iterator[tuple[int, Frame]]:
    """A vehicle that slides over a still background by 0.6 px a frame."""
    street = texture((260, 346), 2.0, 1)
    rows, columns = VEHICLE
    vehicle = texture((rows, columns + 1), 1.5, 2)
    for k in range(FRAMES):
        x = 20.0 + 0.6 * k
        left, share = int(x), np.float32(x - int(x))
        frame = street.copy()
        shifted = share * vehicle[:, :-1] + (1 - share) * vehicle[:, 1:]
        frame[100 : 100 + rows, left : left + columns] = shifted
        yield k * 1000, (level_cd_m2 * frame).astype(np.float32)


@pytest.mark.benchmark(
    group=f"{FRAMES - 5} frames through the sensor, 346×260, 1 kHz [CPU]", timer=process_time
)
@pytest.mark.parametrize("level_cd_m2", [1000.0, 1.0], ids=["day", "night"])
@pytest.mark.parametrize("noise", [True, False], ids=["noisy", "noise_free"])
def test_vehicle_crossing(benchmark: BenchmarkFixture, level_cd_m2: float, noise: bool) -> None:
    config = SensorConfig() if noise else SensorConfig.noise_free()
    frames = list(crossing(level_cd_m2))

    def settled() -> tuple[tuple[Davis346], dict[str, object]]:
        sensor = Davis346(config, seed=1)
        for sample in frames[:5]:
            sensor.step(*sample)
        return (sensor,), {}

    def run(sensor: Davis346) -> int:
        return sum(sensor.step(*sample).events.size for sample in frames[5:])

    pedantic: Callable[..., int] = benchmark.pedantic
    assert pedantic(run, setup=settled, rounds=5, warmup_rounds=1) > 0
