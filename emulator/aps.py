"""The active pixel sensor: frames by global shutter, exposed over the very steps of the light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator._compile import compiled
from emulator.aps_config import ApsConfig

_STREAM = 1

_EXPOSURE_RATIO_MAX = 8.0
"""Largest factor by which one frame changes the exposure (assumed: three stops)."""

_METERING_ROUNDS = 12
"""Meterings before the first frame (assumed): enough to cross the range of exposures twice."""

Image = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class ApsFrame:
    """One frame.

    Attributes:
        start_us: start of the exposure [µs].
        end_us: end of the exposure [µs].
        image: (height, width) uint16, 0 to 1023 [DN].
    """

    start_us: int
    end_us: int
    image: npt.NDArray[np.uint16]

    @property
    def exposure_us(self) -> int:
        """Duration of the exposure [µs]."""
        return self.end_us - self.start_us


@compiled
def add_light(
    total: Image, before: Image, after: Image, weight_before: float, weight_after: float
) -> None:
    """Add weight_before·before + weight_after·after to `total`, in place; all (pixels,)."""
    share_before, share_after = np.float32(weight_before), np.float32(weight_after)
    for i in range(total.size):
        total[i] += share_before * before[i] + share_after * after[i]


def trapezoid_weights(from_us: int, to_us: int, start_us: int, end_us: int) -> tuple[float, float]:
    """Weights of the two ends in the integral of a straight line over part of a step.

    Args:
        from_us: start of the step, whose light is the first end [µs].
        to_us: end of the step [µs].
        start_us: start of the part, not before `from_us` [µs].
        end_us: end of the part, not after `to_us` [µs].

    Returns:
        Weights of the light at `from_us` and at `to_us` [s]; their sum is the part's duration.
    """
    span_s = (end_us - start_us) * 1e-6
    after = (0.5 * (start_us + end_us) - from_us) / (to_us - from_us)
    return span_s * (1.0 - after), span_s * after


class Aps:
    """Exposes, converts and meters frame after frame. It holds one integral, never a clip."""

    def __init__(self, config: ApsConfig, *, lux_per_cd_m2: float, dark_lux: float, seed: int):
        self._config = config
        self._electrons_per_cd_s = config.electrons_per_lux_s * lux_per_cd_m2
        self._dark_electrons_per_s = config.electrons_per_lux_s * dark_lux
        self._seed = seed
        self._exposure_us = config.exposure_us
        self._frames = 0
        self._start_us = 0
        self._light = np.empty(0, np.float32)

    def begin(self, t_us: int, luminance: Image) -> None:
        """Start the first exposure, metered as by a camera that has watched the scene for long.

        Args:
            t_us: time of the first sample [µs].
            luminance: (height, width) light at that time [cd/m²].
        """
        self._start_us = t_us
        self._light = np.zeros_like(luminance)
        for _ in range(_METERING_ROUNDS):
            electrons = self._electrons(luminance * (self._exposure_us * 1e-6))
            self._exposure_us = self._metered_exposure_us(self._convert(electrons))

    def expose(
        self, before: Image, after: Image, *, from_us: int, to_us: int
    ) -> tuple[ApsFrame, ...]:
        """Take in one step of light.

        Args:
            before: (height, width) light at `from_us` [cd/m²].
            after: (height, width) light at `to_us` [cd/m²]; a straight line lies between.
            from_us: start of the step [µs].
            to_us: end of the step [µs].

        Returns:
            The frames whose exposure ended in the step.
        """
        finished = []
        while self._start_us < to_us:
            start_us = max(from_us, self._start_us)
            end_us = min(to_us, self._start_us + self._exposure_us)
            weights = trapezoid_weights(from_us, to_us, start_us, end_us)
            add_light(self._light.ravel(), before.ravel(), after.ravel(), *weights)
            if end_us < self._start_us + self._exposure_us:
                break
            finished.append(self._read_out(end_us))
        return tuple(finished)

    def _read_out(self, end_us: int) -> ApsFrame:
        """Convert the integral, meter it, and set the next exposure up."""
        electrons = self._electrons(self._light)
        if self._config.noise:
            self._add_noise(electrons)
        frame = ApsFrame(self._start_us, end_us, self._convert(electrons))
        self._frames += 1
        self._start_us = max(
            self._start_us + self._config.period_min_us, end_us + self._config.readout_us
        )
        self._exposure_us = self._metered_exposure_us(frame.image)
        self._light.fill(0.0)
        return frame

    def _electrons(self, light_cd_s_m2: Image) -> Image:
        dark = self._dark_electrons_per_s * self._exposure_us * 1e-6
        return np.asarray(light_cd_s_m2 * self._electrons_per_cd_s + dark, np.float32)

    def _add_noise(self, electrons: Image) -> None:
        """Photon shot noise (variance = mean) and read noise, as one Gaussian, in place.

        Where a count is too small for a Gaussian, read noise of tens of electrons hides it.
        """
        rng = np.random.default_rng((self._seed, _STREAM, self._frames))
        deviation = np.sqrt(electrons + self._config.read_noise_e**2)
        electrons += deviation * rng.standard_normal(electrons.shape, np.float32)

    def _convert(self, electrons: Image) -> npt.NDArray[np.uint16]:
        """Fill the wells, then round to levels; below 0 the converter reads 0."""
        levels = np.clip(electrons, 0.0, self._config.full_well_e) / self._config.electrons_per_dn
        return np.asarray(np.rint(levels), np.uint16)

    def _metered_exposure_us(self, image: npt.NDArray[np.uint16]) -> int:
        """Exposure that would bring the mean of `image` to the target, if nothing saturates."""
        config = self._config
        if not config.auto_exposure:
            return config.exposure_us
        ratio = config.target_dn / max(float(image.mean()), 1e-3)
        ratio = min(max(ratio, 1.0 / _EXPOSURE_RATIO_MAX), _EXPOSURE_RATIO_MAX)
        wanted = round(self._exposure_us * ratio)
        return min(max(wanted, config.exposure_min_us), config.exposure_max_us)
