"""Random oscillations: camera shake, and trees in the wind."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]

SINES = 6
"""Sine waves per axis; with so many the sum does not visibly repeat within seconds (assumed)."""


@dataclass(frozen=True, eq=False)
class Oscillation:
    """A random displacement with a given spectrum: a sum of sine waves per axis.

    Attributes:
        hz: (2, SINES) frequencies of x and y [Hz].
        amplitude_px: (2, SINES) amplitudes [px].
        phase: (2, SINES) phases [rad].
    """

    hz: F64
    amplitude_px: F64
    phase: F64

    @property
    def max_speed_px_s(self) -> float:
        """Upper bound of the speed [px/s]."""
        return float(np.hypot(*(2 * math.pi * self.hz * self.amplitude_px).sum(axis=1)))

    @property
    def max_displacement_px(self) -> float:
        """Upper bound of the displacement along either axis [px]."""
        return float(self.amplitude_px.sum(axis=1).max())

    def at(self, t_s: F64) -> F64:
        """Return the displacement (n, 2) [px] at times (n,) [s]."""
        angle = 2 * math.pi * self.hz[..., None] * t_s + self.phase[..., None]
        return np.asarray((self.amplitude_px[..., None] * np.sin(angle)).sum(axis=1).T, np.float64)


def random_oscillation(
    rms_px: tuple[float, float], band_hz: tuple[float, float], rng: np.random.Generator
) -> Oscillation:
    """Draw an oscillation at random, with amplitudes proportional to 1/frequency.

    Args:
        rms_px: root mean square of the displacement along x and y [px].
        band_hz: lowest and highest frequency [Hz]; frequencies are log-uniform between them.
        rng: random generator for frequencies and phases.
    """
    low, high = np.log(band_hz)
    hz = np.exp(rng.uniform(low, high, (2, SINES)))
    amplitude = 1 / hz
    power = (amplitude**2).sum(axis=1, keepdims=True) / 2
    amplitude *= np.array(rms_px)[:, None] / np.sqrt(power)
    return Oscillation(hz, amplitude, rng.uniform(0, 2 * math.pi, (2, SINES)))
