"""The state of all event pixels, and what is frozen about them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator._compile import compiled
from emulator.change_detector import draw_thresholds
from emulator.config import SensorConfig
from emulator.noise import NoiseLaw, draw_hot_rates, exponential, noise_law
from emulator.optics import lux_per_cd_m2

Floats = npt.NDArray[np.float32]


class PixelState(NamedTuple):
    """What a pixel remembers; each field (pixels,), row by row. 48 bytes a pixel.

    A sleeping pixel (its light constant, no event before `wake_us`) is left as it was at
    `touched_us`. Differences, not levels, are kept, since float32 resolves them to 1e-8.

    Attributes:
        luminance: light at the last sample [cd/m²].
        log_lux: u, logarithm of the current at the last sample [ln lux].
        lag: u less the photoreceptor's output [ln units].
        change: photoreceptor's output less the memorised value, without leak [ln units].
        leak: what leak has added to that difference since the last event [ln units].
        clock: what is left of the unit exponential that times the next noise event.
        busy_us: what is left of the refractory period [µs].
        draws: random numbers used so far.
        touched_us: time up to which the other fields hold [µs from the first sample].
        wake_us: no event is possible before, unless the light changes [µs from the first sample].
    """

    luminance: Floats
    log_lux: Floats
    lag: Floats
    change: Floats
    leak: Floats
    clock: Floats
    busy_us: Floats
    draws: npt.NDArray[np.uint32]
    touched_us: npt.NDArray[np.int64]
    wake_us: npt.NDArray[np.int64]


class FrozenMaps(NamedTuple):
    """What mismatch has made of each pixel, once and for all; each field (pixels,).

    Attributes:
        theta_on: ON thresholds [ln units].
        theta_off: OFF thresholds, positive [ln units].
        hot_rate: rate of hot pixels, 0 for the others [events/µs].
    """

    theta_on: Floats
    theta_off: Floats
    hot_rate: Floats


class PixelModel(NamedTuple):
    """Constants of the kernels, the same for all pixels.

    Attributes:
        lux_per_cd_m2: illuminance of the chip per luminance of the scene.
        dark_lux: dark current [lux].
        corner_per_lux: 1/τ of the photoreceptor per lux [1/(µs·lux)].
        corner_limit: 1/τ that the biases allow [1/µs].
        log_limit: u above which the biases limit [ln lux].
        refractory_us: refractory period [µs].
        noise: rates of noise against light.
        seed: of the random numbers in the kernels.
    """

    lux_per_cd_m2: float
    dark_lux: float
    corner_per_lux: float
    corner_limit: float
    log_limit: float
    refractory_us: float
    noise: NoiseLaw
    seed: np.uint64


def draw_maps(config: SensorConfig, rng: np.random.Generator) -> FrozenMaps:
    """Draw the thresholds and the hot pixels of a sensor."""
    pixels = config.width * config.height
    return FrozenMaps(
        theta_on=draw_thresholds(config.theta_on, config.theta_mismatch, pixels, rng),
        theta_off=draw_thresholds(config.theta_off, config.theta_mismatch, pixels, rng),
        hot_rate=draw_hot_rates(config, rng),
    )


def make_model(config: SensorConfig, seed: np.uint64) -> PixelModel:
    """Constants of the kernels for a sensor."""
    per_hz = 2.0 * math.pi * 1e-6
    return PixelModel(
        lux_per_cd_m2=lux_per_cd_m2(f_number=config.f_number, transmission=config.transmission),
        dark_lux=config.dark_lux,
        corner_per_lux=per_hz * config.bandwidth_hz_per_lux,
        corner_limit=per_hz * config.bandwidth_limit_hz,
        log_limit=math.log(config.bandwidth_limit_hz / config.bandwidth_hz_per_lux),
        refractory_us=float(config.refractory_us),
        noise=noise_law(config),
        seed=seed,
    )


@compiled
def wind_clocks(seed: np.uint64, clock: Floats) -> None:
    """Draw the first unit exponential of every pixel into `clock`, in place."""
    for i in range(clock.size):
        clock[i] = exponential(seed, i, 0)


def settled_state(luminance: Floats, model: PixelModel, leak: Floats) -> PixelState:
    """Pixels that have looked at one scene for long.

    Args:
        luminance: (pixels,) light of the scene [cd/m²].
        model: the sensor.
        leak: (pixels,) how far leak has come towards the next event [ln units].
    """
    pixels = luminance.size
    lux = luminance.astype(np.float64) * model.lux_per_cd_m2
    clock = np.empty(pixels, np.float32)
    wind_clocks(model.seed, clock)
    return PixelState(
        luminance=luminance.copy(),
        log_lux=np.log(lux + model.dark_lux).astype(np.float32),
        lag=np.zeros(pixels, np.float32),
        change=np.zeros(pixels, np.float32),
        leak=leak.copy(),
        clock=clock,
        busy_us=np.zeros(pixels, np.float32),
        draws=np.ones(pixels, np.uint32),
        touched_us=np.zeros(pixels, np.int64),
        wake_us=np.zeros(pixels, np.int64),
    )
