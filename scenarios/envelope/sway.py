"""Motion that goes nowhere: the shake of a camera, and leaves in the wind."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]

TONES = 6
"""Sine waves an axis; enough that the sum does not visibly repeat within seconds (assumed)."""


@dataclass(frozen=True, eq=False)
class Sway:
    """A displacement with a given spectrum: sine waves of random frequency and phase.

    Attributes:
        hz: (2, TONES) frequencies of x and y [Hz].
        amplitude_px: (2, TONES) [px].
        phase: (2, TONES) [rad].
    """

    hz: F64
    amplitude_px: F64
    phase: F64

    @property
    def fastest_px_s(self) -> float:
        """A speed that is never exceeded [px/s]."""
        return float(np.hypot(*(2 * math.pi * self.hz * self.amplitude_px).sum(axis=1)))

    @property
    def farthest_px(self) -> float:
        """A displacement along an axis that is never exceeded [px]."""
        return float(self.amplitude_px.sum(axis=1).max())

    def at(self, t_s: F64) -> F64:
        """Displacement at times, (n,) [s] to (n, 2) [px]."""
        angle = 2 * math.pi * self.hz[..., None] * t_s + self.phase[..., None]
        return np.asarray((self.amplitude_px[..., None] * np.sin(angle)).sum(axis=1).T, np.float64)


def make_sway(
    rms_px: tuple[float, float], band_hz: tuple[float, float], rng: np.random.Generator
) -> Sway:
    """Draw a sway whose spectrum falls with frequency: amplitudes as 1/f.

    Args:
        rms_px: root mean square of the displacement along x and y [px].
        band_hz: lowest and highest frequency [Hz]; drawn evenly on a logarithmic scale.
        rng: of frequencies and phases.
    """
    low, high = np.log(band_hz)
    hz = np.exp(rng.uniform(low, high, (2, TONES)))
    amplitude = 1 / hz
    power = (amplitude**2).sum(axis=1, keepdims=True) / 2
    amplitude *= np.array(rms_px)[:, None] / np.sqrt(power)
    return Sway(hz, amplitude, rng.uniform(0, 2 * math.pi, (2, TONES)))
