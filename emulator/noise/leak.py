"""The leak of the change detector: it moves the memorised value down, which gives ON events.

A junction leak drains the memory of each pixel; parasitic photocurrent adds to it in light (Nozaki,
Delbruck 2017). The leak differs from pixel to pixel. In the intervals that Joubert et al. 2021
(Front. Neurosci. 15; 50×50 pixels) recorded at 161 lux and 3 klux, most pixels follow a log-normal
distribution, and about one in ten a second one with a heavy tail. Hot pixels are the end of it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator.config import SensorConfig
from flybench.kernels import inlined

TAIL_FACTOR = math.exp(0.8)
"""Median leak of the pixels in the tail, over the median of the others (fitted to the recordings
of Joubert 2021)."""


class LeakLaw(NamedTuple):
    """Drift of the memorised value, for a pixel with the median leak.

    Attributes:
        dark: drift without light [ln units/µs].
        per_lux: additional drift per illuminance [ln units/(µs·lux)].
    """

    dark: float
    per_lux: float


def leak_law(config: SensorConfig) -> LeakLaw:
    """Return the leak of a sensor."""
    return LeakLaw(
        dark=config.warm_leak_hz * config.theta_on * 1e-6,
        per_lux=config.leak_hz_per_lux * config.theta_on * 1e-6,
    )


@inlined
def leak_drift(law: LeakLaw, lux: float, factor: float) -> float:
    """Return the drift of the memorised value [ln units/µs].

    In a pixel with the median leak and the nominal threshold it causes leak_hz +
    leak_hz_per_lux·E ON events per second (Nozaki, Delbruck 2017).

    Args:
        law: leak of the sensor.
        lux: illuminance on the chip [lux].
        factor: leak of this pixel over the median.
    """
    return (law.dark + law.per_lux * lux) * factor


def draw_leak_factors(config: SensorConfig, rng: np.random.Generator) -> npt.NDArray[np.float32]:
    """Draw the leak of each pixel over the median: (pixels,) float32, log-normal with a tail."""
    pixels = config.width * config.height
    in_tail = rng.random(pixels) < config.leak_tail_fraction
    normal = rng.standard_normal(pixels)
    tail = TAIL_FACTOR * np.exp(config.leak_tail_spread * normal)
    factors = np.where(in_tail, tail, np.exp(config.leak_spread * normal))
    return np.asarray(factors, np.float32)
