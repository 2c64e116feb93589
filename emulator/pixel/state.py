"""The state of all event pixels, their mismatch, and the constants of the kernels."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from emulator.config import SensorConfig
from emulator.noise.faulty_pixels import draw_crazy_rates, draw_hot_rates
from emulator.noise.leak import LeakLaw, draw_leak_factors, leak_law
from emulator.noise.photoreceptor_noise import draw_dark_factors
from emulator.noise.random_numbers import exponential
from emulator.pixel.change_detector import draw_thresholds
from emulator.pixel.optics import lux_per_cd_m2
from flybench.kernels import compiled

MOVED = np.uint32(1 << 31)
"""The highest bit of `draws`, see `PIXEL_DTYPE`."""

DRAWS = np.uint32(3)
"""Random numbers of an event of a pixel with noise: what it was, the clock, and the noise at the
end of the reset."""

BLOCK = 64
"""Number of neighbouring pixels in a block: one bit each of a 64-bit mask."""

Floats = npt.NDArray[np.float32]
Ticks = npt.NDArray[np.int32]
"""Times [µs from the first sample], modulo 2^32. Differences of up to 35 minutes are exact; none is
greater, since a pixel sleeps for 18 minutes at most."""


PIXEL_DTYPE = np.dtype(
    [
        ("lag", np.float32),
        ("second_lag", np.float32),
        ("change", np.float32),
        ("leak", np.float32),
        ("clock", np.float32),
        ("draws", np.uint32),
        ("updated_us", np.int32),
        ("theta_on", np.float32),
        ("theta_off", np.float32),
        ("hot_rate", np.float32),
        ("dark_factor", np.float32),
        ("leak_factor", np.float32),
    ],
    align=True,
)
"""State and mismatch of one pixel. It holds differences, not levels, since float32 resolves
differences to 1e-8. With its luminance, its wake time and the follower, a pixel takes 56 bytes: 36
of state, 20 of mismatch.

lag: u minus the photoreceptor's output [ln units].
second_lag: photoreceptor's output minus the follower's, 0 without a follower [ln units].
change: photoreceptor's output minus the memorised value, without leak [ln units].
leak: contribution of the leak to that difference since the last event [ln units]; in a pixel held
    in reset, where this is zero, minus the rest of the refractory period [µs].
clock: rest of the unit exponential random number that times the next noise event: it loses the
    hazard of one.
draws: number of random numbers used so far; in its highest bit, of a pixel with noise, whether a
    change of the light may still contribute to its next event.
updated_us: time at which the state above was computed; the state of a sleeping pixel (constant
    luminance, no event before its wake time) is not updated.
theta_on: ON threshold [ln units].
theta_off: OFF threshold, positive [ln units].
hot_rate: rate of a hot pixel; minus the rate of a crazy pixel, which fires ON and OFF; 0 for other
    pixels [events/µs].
dark_factor: dark current over that of the median pixel.
leak_factor: leak over that of the median pixel.
"""

Pixels: TypeAlias = npt.NDArray[Any]
"""One-dimensional structured array of `PIXEL_DTYPE`, row by row."""


class PixelState(NamedTuple):
    """State of all pixels, row by row.

    Attributes:
        luminance: (pixels,) luminance at the last sample [cd/m²].
        wake_us: (pixels,) time before which no event is possible unless the luminance changes.
        block_wake_us: (blocks,) earliest `wake_us` of each block.
        pixels: (pixels,) state and mismatch of each pixel.
    """

    luminance: Floats
    wake_us: Ticks
    block_wake_us: Ticks
    pixels: Pixels


class PixelModel(NamedTuple):
    """Constants of the kernels, equal for all pixels.

    Attributes:
        lux_per_cd_m2: illuminance on the chip per luminance of the scene.
        dark_lux: dark current of the median pixel [lux].
        corner_per_lux: 1/τ of the photoreceptor per lux [1/(µs·lux)].
        corner_limit: 1/τ that the biases allow [1/µs].
        log_limit: u above which the biases limit 1/τ [ln lux].
        refractory_us: refractory period [µs].
        follower_us: time constant of the follower, 0 without a follower [µs].
        leak: drift of the memorised value.
        sigma_0: noise of the photoreceptor without limits of the bandwidth [ln units].
        seed: seed of the random numbers in the kernels.
    """

    lux_per_cd_m2: float
    dark_lux: float
    corner_per_lux: float
    corner_limit: float
    log_limit: float
    refractory_us: float
    follower_us: float
    leak: LeakLaw
    sigma_0: float
    seed: np.uint64


class StepTimes(NamedTuple):
    """Start and end of a step [µs from the first sample]."""

    from_us: int
    to_us: int


def draw_pixels(config: SensorConfig, rng: np.random.Generator) -> Pixels:
    """Draw the thresholds and the faulty pixels of a sensor; the state is zero.

    A dead pixel has infinite thresholds, and a noise clock that never runs out.
    """
    count = config.width * config.height
    pixels = np.zeros(count, PIXEL_DTYPE)
    pixels["theta_on"] = draw_thresholds(config.theta_on, config.theta_mismatch, count, rng)
    pixels["theta_off"] = draw_thresholds(config.theta_off, config.theta_mismatch, count, rng)
    pixels["hot_rate"] = draw_hot_rates(config, rng)
    faults, spreads = rng.spawn(2)
    crazy_rate = draw_crazy_rates(config, faults)
    pixels["hot_rate"] = np.where(crazy_rate > 0.0, -crazy_rate, pixels["hot_rate"])
    dead = faults.random(count) < config.dead_fraction
    pixels["theta_on"][dead] = pixels["theta_off"][dead] = np.inf
    pixels["hot_rate"][dead] = 0.0
    pixels["dark_factor"] = draw_dark_factors(config, spreads)
    pixels["leak_factor"] = draw_leak_factors(config, spreads)
    return pixels


def make_model(config: SensorConfig, seed: np.uint64) -> PixelModel:
    """Return the constants of the kernels for a sensor."""
    per_hz = 2.0 * math.pi * 1e-6
    return PixelModel(
        lux_per_cd_m2=lux_per_cd_m2(f_number=config.f_number, transmission=config.transmission),
        dark_lux=config.warm_dark_lux,
        corner_per_lux=per_hz * config.bandwidth_hz_per_lux,
        corner_limit=per_hz * config.bandwidth_limit_hz,
        log_limit=math.log(config.bandwidth_limit_hz / config.bandwidth_hz_per_lux),
        refractory_us=float(config.refractory_us),
        follower_us=1.0 / (per_hz * config.follower_hz) if config.follower_hz > 0.0 else 0.0,
        leak=leak_law(config),
        sigma_0=config.noise_sigma,
        seed=seed,
    )


@compiled
def start_clocks(pixels: Pixels, seed: np.uint64) -> None:
    """Start the noise clocks of all pixels.

    Args:
        pixels: (pixels,) changed in place.
        seed: seed of the random numbers.
    """
    for i in range(pixels.size):
        dead = pixels[i].theta_on == np.inf
        pixels[i].clock = np.inf if dead else exponential(seed, i, 0)
        pixels[i].draws = 1


def settled_state(luminance: Floats, model: PixelModel, pixels: Pixels) -> PixelState:
    """Return the state of pixels that have settled to a scene.

    Args:
        luminance: (pixels,) luminance of the scene [cd/m²].
        model: constants of the sensor.
        pixels: (pixels,) as drawn; changed in place.
    """
    start_clocks(pixels, model.seed)
    return PixelState(
        luminance=luminance.copy(),
        wake_us=np.zeros(luminance.size, np.int32),
        block_wake_us=np.zeros(-(-luminance.size // BLOCK), np.int32),
        pixels=pixels,
    )
