"""Digests of the output of every sensor for synthetic luminance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any, get_args

import numpy as np
import numpy.typing as npt

from emulator import (
    ApsConfig,
    Bias,
    Biases,
    EventSensor,
    ReadoutConfig,
    SensorConfig,
    preset,
    with_biases,
)
from emulator.presets import PresetName
from tests.digests.exact import Case

Image = npt.NDArray[np.float32]
STEP_US = 2_000
STEPS = 250
SPEED_PX_S = 400.0
PATCH_PX = 7
SMALL = SensorConfig(width=120, height=90)
SENSORS: dict[str, SensorConfig] = {name: preset(name) for name in get_args(PresetName)} | {
    "biases": with_biases(SMALL, Biases(on=Bias(5, 200), follower=Bias(1, 33))),
    "biases_davis240": with_biases(preset("davis240"), Biases.preset("davis240")),
    "follower": replace(SMALL, follower_hz=300.0),
    "warm_and_broken": replace(SMALL, temperature_c=60.0, dead_fraction=0.01, crazy_fraction=0.01),
    "slow_bus": replace(
        SMALL, readout=ReadoutConfig(limit_hz=2e4, latency_us=5), refractory_us=200
    ),
    "rolling_shutter": replace(SMALL, aps=ApsConfig(shutter="rolling", auto_exposure=False)),
}


def moving_box(width: int, height: int, *, steps: int = STEPS) -> Iterator[tuple[int, Image]]:
    """A textured box that moves to the right before a textured wall, in dim and bright parts."""
    rng = np.random.default_rng(11)
    wall = _texture(rng.uniform(20.0, 60.0, (height, width)))
    wall[:, : width // 4] *= np.float32(0.01)
    rows, columns = height // 2, width // 3
    box = _texture(rng.uniform(50.0, 150.0, (rows, columns)))
    for step in range(steps):
        place = -columns / 2 + SPEED_PX_S * step * STEP_US * 1e-6
        image, whole = wall.copy(), int(np.floor(place))
        share = np.float32(place - whole)
        smooth = np.zeros((rows, columns + 1), np.float32)
        smooth[:, :-1] += (1 - share) * box
        smooth[:, 1:] += share * box
        left, right = max(whole, 0), min(whole + columns + 1, width)
        if left < right:
            image[height // 4 : height // 4 + rows, left:right] = smooth[
                :, left - whole : right - whole
            ]
        yield step * STEP_US, image


def _texture(noise: npt.NDArray[np.float64]) -> Image:
    """Noise in patches of several pixels, whose edges are sharp."""
    rows, columns = (np.arange(size) // PATCH_PX * PATCH_PX for size in noise.shape)
    return noise[rows][:, columns].astype(np.float32)


def outputs(name: str, *, seed: int = 5, threads: int = 1, steps: int = 100) -> Iterator[Any]:
    """Events, causes, frames and readout of every step of a sensor."""
    config = SENSORS[name]
    sensor = EventSensor(config, seed=seed, threads=threads)
    yield from sensor.stream(moving_box(config.width, config.height, steps=steps))


def windowed() -> Iterator[Any]:
    """Yield the output of a sensor that is given the rectangle in which the luminance changes."""
    sensor = EventSensor(SMALL, seed=8)
    window = (0, SMALL.height // 4, SMALL.width, SMALL.height * 3 // 4)
    for t_us, image in moving_box(SMALL.width, SMALL.height, steps=60):
        yield sensor.step(t_us, image, changed=window)


CASES: dict[str, Case] = {f"sensor.{name}": Case(partial(outputs, name)) for name in SENSORS} | {
    "sensor.two_threads.davis346": Case(partial(outputs, "davis346", threads=2)),
    "sensor.two_threads.follower": Case(partial(outputs, "follower", threads=2)),
    "sensor.other_seed.davis346": Case(partial(outputs, "davis346", seed=6, steps=40)),
    "sensor.windowed": Case(windowed),
}
