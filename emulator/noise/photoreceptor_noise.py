"""The noise of the photoreceptor: Gaussian, on the signal, and low-passed with it.

The shot noise of photodiode and feedback transistor is white, with the density 4q/I of the
logarithm. Its bandwidth is proportional to the current I, so that the variance σ0² = q/(C·U) at the
photoreceptor's output does not depend on the light. A bandwidth that stops growing with the light
cuts the noise, and σ² falls as 1/I: at the limit that the biases set, and at the follower (Graça,
Delbruck 2021: noise events become rarer above a certain illuminance).

    σ² = σ0²·min(1, f_limit/(k·I))·f2/(f1 + f2)

with the cutoff f1 = min(k·I, f_limit) of the photoreceptor and f2 of the follower; without a
follower the last factor is 1.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from emulator.config import SensorConfig
from flybench.kernels import inlined

SMOOTHING = 1.6
"""How much rarer crossings become because two low-passes in a row make the noise smooth (fitted to
the exact simulation of the tests; see `noise_of`)."""


class Noise(NamedTuple):
    """Noise of one pixel at one illuminance.

    Attributes:
        sigma: standard deviation at the pixel's output [ln units].
        per_tau: reciprocal of its correlation time, the sum of the time constants [1/µs].
        smoothing: factor s in the rate 1/τ/(1 + s·h) of crossings of a threshold that is h standard
            deviations away; 0 without a follower.
    """

    sigma: float
    per_tau: float
    smoothing: float


@inlined
def noise_of(sigma_0: float, corner: float, open_corner: float, follower_us: float) -> Noise:
    """Return the noise of a pixel.

    Args:
        sigma_0: standard deviation without limits of the bandwidth [ln units].
        corner: 1/τ1 of the photoreceptor [1/µs].
        open_corner: 1/τ1 that it would have without the limit of the biases [1/µs].
        follower_us: time constant τ2 of the follower, 0 without one [µs].
    """
    tau_us = 1.0 / corner
    total_us = tau_us + follower_us
    per_tau = 1.0 / total_us
    sigma = sigma_0 * math.sqrt(1.0 / (open_corner * total_us))
    return Noise(sigma, per_tau, SMOOTHING * math.sqrt(tau_us * follower_us) * per_tau)


def draw_dark_factors(config: SensorConfig, rng: np.random.Generator) -> npt.NDArray[np.float32]:
    """Draw the dark current of each pixel over the median: (pixels,) float32, log-normal."""
    normal = rng.standard_normal(config.width * config.height)
    return np.exp(config.dark_current_spread * normal).astype(np.float32)
