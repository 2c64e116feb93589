"""Band-limited noise in closed form: a seeded sum of sinusoids with a given spectrum.

The power spectral density is flat up to a corner frequency f_c and falls as f⁻⁴ above it,
S(f) ∝ 1/(1 + (f/f_c)⁴), like that of a mass on a damped spring that is excited at random.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

TONES = 24
"""Number of sinusoids in each noise (assumed: enough that nothing repeats within a minute)."""
_HIGHEST = 12.0
"""Highest frequency, in corner frequencies; 0.02 % of the power lies above it."""

F64 = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BandLimitedNoise:
    """A sum of sinusoids of equal power.

    Attributes:
        amplitude: amplitude of each sinusoid, in the unit of the value.
        angular_rad_s: (n,) 2π × frequency of each sinusoid [rad/s].
        phase_rad: (n,) phase of each sinusoid at time 0 [rad].
    """

    amplitude: float
    angular_rad_s: F64
    phase_rad: F64

    def value(self, t_s: float) -> float:
        """Return the value at a time [s]."""
        return self.amplitude * float(np.sin(self.angular_rad_s * t_s + self.phase_rad).sum())

    def rate(self, t_s: float) -> float:
        """Return the derivative at a time [1/s]."""
        cosine = np.cos(self.angular_rad_s * t_s + self.phase_rad)
        return self.amplitude * float(self.angular_rad_s @ cosine)

    @property
    def rms(self) -> float:
        """Root mean square over all time: √n times that of each sinusoid."""
        return self.amplitude * math.sqrt(len(self.phase_rad) / 2)

    @property
    def rms_rate(self) -> float:
        """Root mean square of the derivative [1/s]."""
        return self.amplitude * float(np.sqrt((self.angular_rad_s**2).sum() / 2))


def band_limited_noise(
    rng: np.random.Generator, *, rms: float, corner_hz: float, tones: int = TONES
) -> BandLimitedNoise:
    """Draw band-limited noise; each tone stands for an equal share of the spectrum's power.

    Args:
        rng: source of the phases and of the frequencies, one in each share of the spectrum.
        rms: root mean square of the value.
        corner_hz: corner frequency f_c of the spectrum [Hz].
        tones: number of sinusoids.
    """
    share = (np.arange(tones) + rng.uniform(size=tones)) / tones
    frequency_hz = corner_hz * _quantile(share)
    return BandLimitedNoise(
        amplitude=rms * math.sqrt(2 / tones),
        angular_rad_s=2 * math.pi * frequency_hz,
        phase_rad=rng.uniform(0, 2 * math.pi, tones),
    )


def _quantile(share: F64) -> F64:
    """Return the frequencies, in corner frequencies, below which given shares of the power lie."""
    grid = np.linspace(0, _HIGHEST, 4001)
    density = 1 / (1 + grid**4)
    power = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)])
    return np.interp(share, power / power[-1], grid)
