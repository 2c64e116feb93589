"""Small sensors and stimuli for the tests of the emulator."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from emulator import EventSensor, SensorConfig
from emulator.pixel.optics import lux_per_cd_m2
from flybench.events import Events

Frame = npt.NDArray[np.float32]
Sample = tuple[int, Frame]

WIDTH, HEIGHT = 16, 12


def noise_free_config(**changes: Any) -> SensorConfig:
    """Return a small sensor of first order without noise or mismatch."""
    config = SensorConfig.noise_free(width=WIDTH, height=HEIGHT)
    plain = {
        "theta_on": 0.18,
        "theta_off": 0.22,
        "theta_mismatch": 0.0,
        "dark_current_spread": 0.0,
        "follower_hz": 0.0,
        "refractory_us": 3,
    }
    return replace(config, **{**plain, **changes})


def noisy_config(**changes: Any) -> SensorConfig:
    """Return a small sensor with all noise, more than usual, and with some hot pixels."""
    config = SensorConfig(width=WIDTH, height=HEIGHT, noise_sigma=0.12, hot_fraction=0.02)
    return replace(config, **changes)


def uniform_frame(luminance_cd_m2: float, config: SensorConfig) -> Frame:
    """Return a frame of one luminance."""
    return np.full((config.height, config.width), luminance_cd_m2, np.float32)


def luminance_for_lux(lux: float, config: SensorConfig) -> float:
    """Return the luminance that gives `lux` on the chip [cd/m²]."""
    scale = lux_per_cd_m2(f_number=config.f_number, transmission=config.transmission)
    return lux / scale


def moving_texture(n: int, *, step_us: int = 1000, level: float = 100.0) -> Iterator[Sample]:
    """Yield a grating with random grain that moves over the small sensor."""
    grain = np.random.default_rng(5).uniform(0.8, 1.2, (HEIGHT, WIDTH))
    x = np.arange(WIDTH)
    for k in range(n):
        wave = 1.0 + 0.8 * np.sin(0.7 * (x - 0.6 * k * step_us / 1000))
        yield k * step_us, (level * wave * grain).astype(np.float32)


def run_sensor(
    config: SensorConfig, samples: Iterable[Sample], *, seed: int = 1, threads: int = 1
) -> tuple[Events, npt.NDArray[np.uint8]]:
    """Return all events of a new sensor over a sequence, and their causes."""
    outputs = list(EventSensor(config, seed=seed, threads=threads).stream(samples))
    events = np.concatenate([output.events for output in outputs])
    return events, np.concatenate([output.causes for output in outputs])


def log_ramp(
    config: SensorConfig, *, start: float, rate_per_s: float, times_us: Iterable[int]
) -> Iterator[Sample]:
    """Yield uniform frames whose log current, dark current included, is linear in time."""
    scale = luminance_for_lux(1.0, config)
    for t_us in times_us:
        current_lux = start * np.exp(rate_per_s * t_us * 1e-6)
        yield t_us, uniform_frame((current_lux - config.dark_lux) * scale, config)


def intervals_us(events: Events) -> npt.NDArray[np.int64]:
    """Return the intervals between consecutive events of the same pixel."""
    order = np.lexsort((events["t"], events["x"], events["y"]))
    ordered = events[order]
    same = (np.diff(ordered["x"]) == 0) & (np.diff(ordered["y"]) == 0)
    return np.asarray(np.diff(ordered["t"])[same])
