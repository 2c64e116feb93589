"""Small scenes and sensors for the emulator's tests."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from emulator import Davis346, SensorConfig
from emulator.pixel.optics import lux_per_cd_m2
from flybench.events import Events

Frame = npt.NDArray[np.float32]
Sample = tuple[int, Frame]

WIDTH, HEIGHT = 16, 12


def quiet(**changes: Any) -> SensorConfig:
    """A small sensor without noise or mismatch."""
    config = SensorConfig.noise_free(width=WIDTH, height=HEIGHT)
    return replace(config, **{"theta_mismatch": 0.0, **changes})


def noisy(**changes: Any) -> SensorConfig:
    """A small sensor with all its noise, and hot pixels among its few."""
    config = SensorConfig(width=WIDTH, height=HEIGHT, hot_fraction=0.02)
    return replace(config, **changes)


def flat(level: float, config: SensorConfig) -> Frame:
    return np.full((config.height, config.width), level, np.float32)


def luminance_for(lux: float, config: SensorConfig) -> float:
    """Luminance that puts `lux` on the chip."""
    scale = lux_per_cd_m2(f_number=config.f_number, transmission=config.transmission)
    return lux / scale


def moving_texture(n: int, *, step_us: int = 1000, level: float = 100.0) -> Iterator[Sample]:
    """A grating with a random grain that slides over the small sensor."""
    grain = np.random.default_rng(5).uniform(0.8, 1.2, (HEIGHT, WIDTH))
    x = np.arange(WIDTH)
    for k in range(n):
        wave = 1.0 + 0.8 * np.sin(0.7 * (x - 0.6 * k * step_us / 1000))
        yield k * step_us, (level * wave * grain).astype(np.float32)


def run(sensor: Davis346, samples: Iterable[Sample]) -> tuple[Events, npt.NDArray[np.uint8]]:
    """Events and causes of a whole sequence."""
    outputs = list(sensor.stream(samples))
    events = np.concatenate([output.events for output in outputs])
    return events, np.concatenate([output.causes for output in outputs])


def log_ramp(
    config: SensorConfig, *, start: float, rate_per_s: float, times_us: Iterable[int]
) -> Iterator[Sample]:
    """Light whose logarithm, dark current included, is a straight line in time."""
    scale = luminance_for(1.0, config)
    for t_us in times_us:
        current_lux = start * np.exp(rate_per_s * t_us * 1e-6)
        yield t_us, flat((current_lux - config.dark_lux) * scale, config)


def gaps_us(events: Events) -> npt.NDArray[np.int64]:
    """Intervals between consecutive events of the same pixel."""
    order = np.lexsort((events["t"], events["x"], events["y"]))
    ordered = events[order]
    same = (np.diff(ordered["x"]) == 0) & (np.diff(ordered["y"]) == 0)
    return np.asarray(np.diff(ordered["t"])[same])
