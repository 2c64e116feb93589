"""Hot and crazy pixels: they fire at random, whatever the light.

Each pixel has a clock that starts at a unit exponential random number and is counted down by
rate·time; an event occurs when it reaches 0. Events and times therefore do not depend on the steps.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from emulator.config import SensorConfig


def draw_hot_rates(config: SensorConfig, rng: np.random.Generator) -> npt.NDArray[np.float32]:
    """Draw the rates of the hot pixels: (pixels,) float32 [events/µs], 0 for other pixels."""
    pixels = config.width * config.height
    hot = rng.random(pixels) < config.hot_fraction
    rates = rng.uniform(config.hot_hz_min, config.hot_hz_max, pixels)
    return np.where(hot, rates * 1e-6, 0.0).astype(np.float32)


def draw_crazy_rates(config: SensorConfig, rng: np.random.Generator) -> npt.NDArray[np.float32]:
    """Draw the rates of the crazy pixels: (pixels,) float32 [events/µs], 0 for other pixels."""
    pixels = config.width * config.height
    crazy = rng.random(pixels) < config.crazy_fraction
    rates = rng.uniform(config.crazy_hz_min, config.crazy_hz_max, pixels)
    return np.where(crazy, rates * 1e-6, 0.0).astype(np.float32)
