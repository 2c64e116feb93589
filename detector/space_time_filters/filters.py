"""The filters of Brosch et al. (2015) in space and time, and their preferred speed."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]
C128 = npt.NDArray[np.complex128]

_EARLY, _LATE = 0.5, 0.75
"""s₁ and s₂, the weights of the two phases of the biphasic filter."""
SUPPORT = 3.5
"""Age at which all temporal filters have ended, in units of μ_bi1: μ_bi2 + 3 σ_bi2."""
_MONO = (1.0 + math.sqrt(36.0 + 10.0 * math.log(_EARLY / _LATE))) / 5.0
"""μ_mono in units of μ_bi1: the zero of the biphasic filter, where the monophasic filter has its
maximum (section 2.2.3). The paper prints a formula that gives this zero for μ_bi1 = 1 only."""


def gaussian(t: F64, mean: float, deviation: float) -> F64:
    """Return the Gaussian function without normalisation (equation 24)."""
    return np.asarray(np.exp(-((t - mean) ** 2) / (2.0 * deviation**2)))


def monophasic(t: F64, mu: float) -> F64:
    """Return the monophasic filter (equation 22).

    Args:
        t: age of an event [s].
        mu: mean of the first phase of the biphasic filter, μ_bi1 [s].
    """
    return gaussian(t, _MONO * mu, _MONO * mu / 3.0)


def biphasic(t: F64, mu: float) -> F64:
    """Return the biphasic filter (equation 23).

    Args:
        t: age of an event [s].
        mu: mean of its first phase, μ_bi1 [s].
    """
    early, late = gaussian(t, mu, mu / 3.0), gaussian(t, 2.0 * mu, mu / 2.0)
    return -_EARLY * early + _LATE * late


def gabor(x: F64, frequency: float, sigma: float) -> C128:
    """Return the factor of one axis of the Gabor filter (equation 20).

    The filter is the product of those of x and y.

    Args:
        x: distance [px].
        frequency: spatial frequency along this axis [1/px].
        sigma: σ of the paper; the standard deviation in the image is σ / 2π [px].
    """
    envelope = math.sqrt(2.0 * math.pi) / sigma * np.exp(-2.0 * (math.pi * x / sigma) ** 2)
    return np.asarray(envelope * np.exp(2j * math.pi * frequency * x))


@cache
def preferred_frequency(mu: float) -> float:
    """Return the temporal frequency to which the filter responds most [Hz] (section 2.2.4).

    At the spatial frequency of the Gabor filter, its even part has the transform 1/2 and its odd
    part 1/2j, so that the response to the frequency f is |T_bi(f) + j T_mono(f)| / 2.

    Args:
        mu: μ_bi1 [s].
    """
    t = np.arange(0.0, SUPPORT, 0.005) * mu
    frequencies = np.arange(-0.5, 0.5, 0.0005) / mu
    waves = np.exp(-2j * math.pi * frequencies[:, None] * t)
    response = np.abs(waves @ (biphasic(t, mu) + 1j * monophasic(t, mu)))
    return float(abs(frequencies[np.argmax(response)]))


def mu_of_speed(speed_px_s: float, frequency: float) -> float:
    """Return μ_bi1 of the filter that prefers a speed [s]; they are inverse (table 1).

    Args:
        speed_px_s: preferred speed [px/s].
        frequency: spatial frequency of the Gabor filter [1/px].
    """
    return preferred_frequency(1.0) / (frequency * speed_px_s)
