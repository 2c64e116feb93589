"""Noise as random processes in time, and their random numbers: leak, shot noise, hot pixels.

Rates are per pixel and depend on the illuminance on the chip alone. Each pixel has a clock that
starts at a unit exponential random number and is counted down by rate·time; a noise event occurs
when it reaches 0. The events and their times therefore do not depend on the steps.

Shot noise is a Poisson process in time whose rate depends on illuminance alone: events are the
first passages of that clock, and nothing is drawn per frame. It is not modelled as a noise voltage
that crosses thresholds. Its rate therefore depends neither on the thresholds and their mismatch nor
on the biases; in a real pixel it does (Graça, Delbruck 2021).

Shot noise rates: background activity of Joubert et al. 2021 (Front. Neurosci. 15; 50×50 pixels):
ON/OFF 5.6/4.2 Hz at 0.1 lux, 0.104/0.0012 Hz at 161 lux, 0.172/0 Hz at 3 klux. Its ON rates
include the leak, which is a separate process here (0.1 Hz + 2.4e-5 Hz/lux, see `SensorConfig`).
What remains for shot noise is 5.5/4.2 Hz at 0.1 lux and 0/0.0012 Hz at 161 lux. One power law
through the OFF points, with a constant ratio of ON to OFF of 5.5:4.2, meets every point within 2 %.
Above 161 lux the power law continues (5e-5 Hz at 3 klux, where the recording had no event). Below
0.1 lux the rate is constant (assumed), since the bandwidth that lets the noise through falls with
the light (Graça, Delbruck 2021). We could not find whether the source gives illuminance on the
scene or on the chip: it is taken as on the chip, as in Graça and Delbruck; that is the
interpretation with more noise.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator.config import SensorConfig
from flybench.kernels import compiled, inlined
from flybench.portable_math import exp, log, sine_and_cosine, to_double

SHOT_LUX = (0.1, 161.0)
SHOT_OFF_HZ = (4.2, 0.0012)
SHOT_ON_PER_OFF = 5.5 / 4.2

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_S32 = np.uint64(32)
_LOW_WORD = np.uint64(0xFFFFFFFF)
_STEP = 2.0**-53
_PER_WORD = 2.0**-32


class NoiseLaw(NamedTuple):
    """Rates per µs as functions of u = ln(current in lux, dark current included).

    Attributes:
        shot_log_min: u below which the rate of shot noise is constant.
        shot_log: logarithm of the OFF rate of shot noise at u = 0.
        shot_power: slope d ln(rate)/du of shot noise.
        leak_dark: drift of the memorised value without light [ln units/µs].
        leak_per_lux: additional drift per illuminance [ln units/(µs·lux)].
        dark_lux: dark current [lux].
    """

    shot_log_min: float
    shot_log: float
    shot_power: float
    leak_dark: float
    leak_per_lux: float
    dark_lux: float


def noise_law(config: SensorConfig) -> NoiseLaw:
    """Return the rates of a sensor: a power law for shot noise, a straight line for the leak."""
    low, high = (math.log(lux + config.dark_lux) for lux in SHOT_LUX)
    scale = config.shot_noise_scale * 1e-6
    power = math.log(SHOT_OFF_HZ[1] / SHOT_OFF_HZ[0]) / (high - low)
    return NoiseLaw(
        shot_log_min=low,
        shot_log=math.log(SHOT_OFF_HZ[0] * scale) - power * low if scale > 0.0 else -math.inf,
        shot_power=power,
        leak_dark=config.warm_leak_hz * config.theta_on * 1e-6,
        leak_per_lux=config.leak_hz_per_lux * config.theta_on * 1e-6,
        dark_lux=config.warm_dark_lux,
    )


@inlined
def shot_rates(law: NoiseLaw, log_lux: float) -> tuple[float, float]:
    """Return the rates of ON and OFF shot noise of a pixel [events/µs] at u = `log_lux`."""
    off = exp(law.shot_log + law.shot_power * max(log_lux, law.shot_log_min))
    return SHOT_ON_PER_OFF * off, off


@inlined
def leak_drift(law: NoiseLaw, current_lux: float) -> float:
    """Return the drift of the memorised value [ln units/µs].

    In a pixel with the nominal threshold it causes leak_hz + leak_hz_per_lux·E ON events per second
    (Nozaki, Delbruck 2017).

    Args:
        law: rates of the sensor.
        current_lux: current including the dark current, as an illuminance [lux].
    """
    return law.leak_dark + law.leak_per_lux * (current_lux - law.dark_lux)


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


@compiled
def uniform(seed: np.uint64, pixel: int, draw: int | np.int64) -> float:
    """Return a random number in (0, 1) that depends on (seed, pixel, draw) alone.

    The finaliser of SplitMix64 (Steele, Lea, Flood 2014), applied to the counter and to the seed.
    """
    z = ((np.uint64(pixel) << _S32) | np.uint64(draw)) * _GOLDEN
    for _ in range(2):
        z = (z ^ (z >> _S30)) * _MIX_1
        z = (z ^ (z >> _S27)) * _MIX_2
        z = (z ^ (z >> _S31)) + seed
    return (np.float64(z >> _S11) + 0.5) * _STEP


@compiled
def exponential(seed: np.uint64, pixel: int, draw: int | np.int64) -> float:
    """Return a unit exponential random number that depends on (seed, pixel, draw) alone."""
    return -log(uniform(seed, pixel, draw))


@compiled
def draw_gaussians(seed: np.uint64, first: np.uint64, out: npt.NDArray[np.float32]) -> None:
    """Fill `out` with independent Gaussian random numbers of unit variance.

    The transform of Box and Muller (1958), applied to the two 32-bit halves of the finaliser of
    SplitMix64; no number is beyond ±6.8.

    Args:
        seed: seed of the sequence.
        first: position in the sequence at which to begin, in pairs.
        out: (n,) float32, output array.
    """
    pairs = (out.size + 1) // 2
    ones, others = out[:pairs], out[out.size - pairs :]
    for k in range(pairs):
        z = (np.uint64(k) + first) * _GOLDEN + seed
        z = (z ^ (z >> _S30)) * _MIX_1
        z = (z ^ (z >> _S27)) * _MIX_2
        z = z ^ (z >> _S31)
        radius = math.sqrt(-2.0 * log((to_double(z >> _S32) + 0.5) * _PER_WORD))
        turn = (to_double(z & _LOW_WORD) + 0.5) * _PER_WORD - 0.5
        sine, cosine = sine_and_cosine(math.pi * turn)
        ones[k] = radius * (2.0 * sine * cosine)
        others[k] = radius * (1.0 - 2.0 * sine * sine)
