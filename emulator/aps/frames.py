"""The active pixel sensor: frames exposed over the steps of the sensor.

The exposure of a pixel is the integral of its luminance, which changes linearly in each step. The
integral is stored as the present luminance times the time exposed so far, plus a correction that
changes only with the luminance: a pixel under constant luminance costs nothing until the frame is
read out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator.aps.config import ApsConfig
from emulator.aps.exposure import (
    Floats,
    Seconds,
    add_correction,
    add_noise,
    collect_electrons,
    convert_to_levels,
    expose_rows,
)
from emulator.errors import FrameError
from emulator.noise.random_numbers import draw_gaussians
from emulator.pixel.active_pixels import Masks
from flybench.memory import check_memory

_RANDOM_STREAM = 1

_EXPOSURE_RATIO_MAX = 8.0
"""Largest factor by which one frame changes the exposure (assumed: three stops)."""

_STEP_FRAMES_MAX = 1000
"""Number of frames that one step may return (assumed; they take 180 MB at 346×260)."""

_BYTES_PER_PX = np.dtype(np.uint16).itemsize

_METERING_ROUNDS = 12
"""Number of meterings before the first frame (assumed): enough to cross the range of exposures
twice."""

Image = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class ApsFrame:
    """One APS frame and the times of its exposure.

    Attributes:
        start_us: start of the exposure; with a rolling shutter, of the first row [µs].
        end_us: end of the exposure; with a rolling shutter, of the last row [µs].
        image: (height, width) uint16, 0 to 1023 [DN].
        rolling_us: delay between the exposures of the first and the last row, 0 with the global
            shutter [µs].
    """

    start_us: int
    end_us: int
    image: npt.NDArray[np.uint16]
    rolling_us: int = 0

    @property
    def exposure_us(self) -> int:
        """Duration of the exposure of each row [µs]."""
        return self.end_us - self.start_us - self.rolling_us


class Aps:
    """Exposes, converts and meters one frame after another; it keeps one integral, never a clip."""

    def __init__(self, config: ApsConfig, *, lux_per_cd_m2: float, dark_lux: float, seed: int):
        self._config = config
        self._electrons_per_cd_s = config.electrons_per_lux_s * lux_per_cd_m2
        self._dark_electrons_per_s = config.electrons_per_lux_s * dark_lux
        self._seed = seed
        self._exposure_us = config.exposure_us
        self._frames = 0
        self._start_us = 0
        self._correction = np.empty(0, np.float32)
        self._seconds, self._weights = np.empty(0), np.empty(0)
        self._delays_us = np.empty(0, np.int64)
        self._gains = np.empty(0, np.float32)
        self._noise_seed = np.uint64(0)

    def begin(self, t_us: int, luminance: Image) -> None:
        """Start the first exposure, with an auto-exposure that has settled to the scene.

        Args:
            t_us: time of the first sample [µs].
            luminance: (height, width) luminance at that time [cd/m²].
        """
        rows, config = luminance.shape[0], self._config
        rolling_us = config.readout_us if config.shutter == "rolling" else 0
        self._delays_us = np.arange(rows) * rolling_us // rows
        self._start_us = t_us
        self._correction = np.zeros(luminance.size, np.float32)
        self._seconds, self._weights = np.zeros(rows), np.zeros(rows)
        rng = np.random.default_rng((self._seed, _RANDOM_STREAM))
        self._noise_seed = rng.integers(2**64, dtype=np.uint64)
        spread = config.fixed_pattern * rng.standard_normal(luminance.size, np.float32)
        self._gains = np.maximum(1.0 + spread, 0.0, dtype=np.float32)
        for _ in range(_METERING_ROUNDS):
            seconds = np.full(rows, self._exposure_us * 1e-6)
            levels = self._convert(self._electrons(luminance, seconds))
            self._exposure_us = self._metered_exposure_us(levels)

    def check_step(self, step_us: int) -> None:
        """Check that the number of frames that a step may return is limited.

        Args:
            step_us: duration of the step [µs].

        Raises:
            FrameError: more than 1000 frames could end in the step.
            MemoryBudgetError: these frames do not fit into the memory budget.
        """
        frames = step_us // self._shortest_period_us() + 1
        needed = frames * self._correction.size * _BYTES_PER_PX
        check_memory(f"A step of {step_us} µs with up to {frames} APS frames", needed)
        longest_us = _STEP_FRAMES_MAX * self._shortest_period_us()
        if step_us > longest_us:
            raise FrameError(
                f"the step is {step_us} µs long, with an APS frame every "
                f"{self._shortest_period_us()} µs at most. Allowed is up to {longest_us} µs, or "
                f"{_STEP_FRAMES_MAX} frames. Take shorter steps, or raise period_min_us."
            )

    def _shortest_period_us(self) -> int:
        config = self._config
        exposure_us = config.exposure_min_us if config.auto_exposure else config.exposure_us
        rolling = config.shutter == "rolling"
        busy_us = int(self._delays_us[-1]) if rolling else config.readout_us
        return max(config.period_min_us, exposure_us + busy_us)

    def expose(
        self, before: Image, after: Image, changed: Masks, *, from_us: int, to_us: int
    ) -> tuple[ApsFrame, ...]:
        """Expose the frames over one step.

        Args:
            before: (height, width) luminance at `from_us` [cd/m²].
            after: (height, width) luminance at `to_us` [cd/m²]; it changes linearly in between.
            changed: (blocks,) masks of the pixels where the two differ.
            from_us: start of the step [µs].
            to_us: end of the step [µs].

        Returns:
            The frames whose exposure ended in the step.
        """
        finished = []
        while self._start_us < to_us:
            start_us, exposure_us, weights = self._start_us, self._exposure_us, self._weights
            expose_rows(
                from_us, to_us, start_us, exposure_us, self._delays_us, self._seconds, weights
            )
            old, new = before.ravel(), after.ravel()
            add_correction(self._correction, old, new, changed, weights, after.shape[1])
            end_us = start_us + int(self._delays_us[-1]) + exposure_us
            if end_us > to_us:
                break
            finished.append(self._read_out(after, end_us))
        return tuple(finished)

    def _read_out(self, luminance: Image, end_us: int) -> ApsFrame:
        """Convert the integral to a frame, meter it, and set up the next exposure."""
        config, rolling_us = self._config, int(self._delays_us[-1])
        electrons = self._electrons(luminance, self._seconds)
        if config.noise:
            first = np.uint64(self._frames * electrons.size)
            normal = np.empty_like(electrons)
            draw_gaussians(self._noise_seed, first, normal)
            add_noise(electrons, normal, config.read_noise_e**2, self._gains)
        image = self._convert(electrons).reshape(luminance.shape)
        frame = ApsFrame(self._start_us, end_us, image, rolling_us)
        self._frames += 1
        rest_us = 0 if rolling_us else config.readout_us
        self._start_us = max(self._start_us + config.period_min_us, end_us + rest_us)
        self._exposure_us = self._metered_exposure_us(frame.image)
        self._correction.fill(0.0)
        self._seconds.fill(0.0)
        return frame

    def _electrons(self, luminance: Image, seconds: Seconds) -> Floats:
        """Return the mean electrons of each pixel, (pixels,), for the exposure of each row [s]."""
        electrons = np.empty(luminance.size, np.float32)
        dark = self._dark_electrons_per_s * self._exposure_us * 1e-6
        gain = self._electrons_per_cd_s
        width = luminance.shape[1]
        collect_electrons(
            self._correction, luminance.ravel(), seconds, width, gain, dark, electrons
        )
        return electrons

    def _convert(self, electrons: Floats) -> npt.NDArray[np.uint16]:
        levels = np.empty(electrons.size, np.uint16)
        per_electron = 1.0 / self._config.electrons_per_dn
        convert_to_levels(electrons, self._config.full_well_e, per_electron, levels)
        return levels

    def _metered_exposure_us(self, image: npt.NDArray[np.uint16]) -> int:
        """Return the exposure that brings the mean of `image` to the target, without saturation."""
        config = self._config
        if not config.auto_exposure:
            return config.exposure_us
        ratio = config.target_dn / max(float(image.mean()), 1e-3)
        ratio = min(max(ratio, 1.0 / _EXPOSURE_RATIO_MAX), _EXPOSURE_RATIO_MAX)
        wanted = round(self._exposure_us * ratio)
        return min(max(wanted, config.exposure_min_us), config.exposure_max_us)
