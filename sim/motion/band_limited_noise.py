"""Irregular motion in closed form: seeded sums of sinusoids with a stated spectrum.

The spectral density of power is flat up to a corner frequency f_c and falls as f⁻⁴ above it,
S(f) ∝ 1/(1 + (f/f_c)⁴), as that of a mass on a damped spring that is shaken at random.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

TONES = 24
"""Sinusoids of each noise (assumed: many enough that nothing repeats within a
minute)."""
_HIGHEST = 12.0
"""In corner frequencies; what is above it holds 0.02 % of the power."""

F64 = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BandLimitedNoise:
    """A sum of sinusoids of equal power.

    Attributes:
        amplitude: of each, in the unit of the value.
        angular_rad_s: (n,) 2π × frequency [rad/s].
        phase_rad: (n,) at time 0 [rad].
    """

    amplitude: float
    angular_rad_s: F64
    phase_rad: F64

    def value(self, t_s: float) -> float:
        """At a time [s]."""
        return self.amplitude * float(np.sin(self.angular_rad_s * t_s + self.phase_rad).sum())

    def rate(self, t_s: float) -> float:
        """Its derivative at a time [1/s]."""
        cosine = np.cos(self.angular_rad_s * t_s + self.phase_rad)
        return self.amplitude * float(self.angular_rad_s @ cosine)

    @property
    def rms(self) -> float:
        """Root mean square over all time: that of each, √n times."""
        return self.amplitude * math.sqrt(len(self.phase_rad) / 2)

    @property
    def rms_rate(self) -> float:
        """Root mean square of its derivative [1/s]."""
        return self.amplitude * float(np.sqrt((self.angular_rad_s**2).sum() / 2))


def band_limited_noise(
    rng: np.random.Generator, *, rms: float, corner_hz: float, tones: int = TONES
) -> BandLimitedNoise:
    """Draw band-limited noise; each tone stands for an equal share of the spectrum's power.

    Args:
        rng: source of frequencies, one at random within each share, and of phases.
        rms: root mean square of the value.
        corner_hz: f_c of the spectrum [Hz].
        tones: how many sinusoids.
    """
    share = (np.arange(tones) + rng.uniform(size=tones)) / tones
    frequency_hz = corner_hz * _quantile(share)
    return BandLimitedNoise(
        amplitude=rms * math.sqrt(2 / tones),
        angular_rad_s=2 * math.pi * frequency_hz,
        phase_rad=rng.uniform(0, 2 * math.pi, tones),
    )


def _quantile(share: F64) -> F64:
    """Frequencies, in corner frequencies, below which a share of the power lies."""
    grid = np.linspace(0, _HIGHEST, 4001)
    density = 1 / (1 + grid**4)
    power = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)])
    return np.interp(share, power / power[-1], grid)
