"""The kernels that expose a frame and convert it to levels; see `emulator.aps.frames`."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from emulator.pixel.active_pixels import Masks
from emulator.pixel.state import BLOCK
from flybench.kernels import compiled
from flybench.portable_math import lowest_bit

_ONE = np.uint64(1)

Floats = npt.NDArray[np.float32]
Seconds = npt.NDArray[np.float64]
Longs = npt.NDArray[np.int64]


@compiled
def trapezoid_weights(from_us: int, to_us: int, start_us: int, end_us: int) -> tuple[float, float]:
    """Return the weights of the two end values in the integral of a line over part of a step.

    Args:
        from_us: start of the step [µs].
        to_us: end of the step [µs].
        start_us: start of the part, not before `from_us` [µs].
        end_us: end of the part, not after `to_us` [µs].

    Returns:
        Weights of the luminance at `from_us` and at `to_us` [s]; their sum is the duration of the
        part.
    """
    span_s = (end_us - start_us) * 1e-6
    after = (0.5 * (start_us + end_us) - from_us) / (to_us - from_us)
    return span_s * (1.0 - after), span_s * after


@compiled
def expose_rows(
    from_us: int,
    to_us: int,
    start_us: int,
    exposure_us: int,
    delays_us: Longs,
    seconds: Seconds,
    weights: Seconds,
) -> None:
    """Add the time for which a step exposes each row; see `trapezoid_weights`.

    Args:
        from_us: start of the step [µs].
        to_us: end of the step [µs].
        start_us: start of the exposure of the first row [µs].
        exposure_us: duration of the exposure of each row [µs].
        delays_us: (rows,) delay of the exposure of each row against the first [µs].
        seconds: (rows,) time exposed so far [s]; changed in place.
        weights: (rows,) output: weight of the luminance at `from_us` in the integral so far [s].
    """
    for row in range(seconds.size):
        begin = min(max(start_us + delays_us[row], from_us), to_us)
        end = min(max(start_us + delays_us[row] + exposure_us, from_us), to_us)
        before, after = trapezoid_weights(from_us, to_us, begin, end)
        weights[row] = seconds[row] + before
        seconds[row] += before + after


@compiled
def add_correction(
    correction: Floats, before: Floats, after: Floats, changed: Masks, weights: Seconds, width: int
) -> None:
    """Add (before − after)·weight of the row to the correction of each pixel that has changed.

    Args:
        correction: (pixels,) [cd·s/m²]; changed in place.
        before: (pixels,) luminance before the change [cd/m²].
        after: (pixels,) luminance after the change [cd/m²].
        changed: (blocks,) masks of the pixels whose luminance has changed.
        weights: (rows,) time for which the luminance before the change still counts [s].
        width: columns of the sensor [px].
    """
    row, row_end = 0, width
    for block in range(changed.size):
        mask = changed[block]
        while mask:
            i = block * BLOCK + int(lowest_bit(mask))
            mask &= mask - _ONE
            while i >= row_end:
                row += 1
                row_end += width
            correction[i] += (before[i] - after[i]) * np.float32(weights[row])


@compiled
def collect_electrons(
    correction: Floats,
    luminance: Floats,
    seconds: Seconds,
    width: int,
    gain: float,
    dark: float,
    out: Floats,
) -> None:
    """Compute the mean electrons, gain·(luminance·seconds of the row + correction) + dark.

    Args:
        correction: (pixels,) [cd·s/m²].
        luminance: (pixels,) present luminance [cd/m²].
        seconds: (rows,) time exposed [s].
        width: columns of the sensor [px].
        gain: electrons per exposure [e⁻/(cd·s/m²)].
        dark: electrons of the dark current [e⁻].
        out: (pixels,) output array [e⁻].
    """
    for row in range(seconds.size):
        factor, whole, offset = np.float32(seconds[row] * gain), np.float32(gain), np.float32(dark)
        here = slice(row * width, (row + 1) * width)
        values, corrected, electrons = luminance[here], correction[here], out[here]
        for i in range(width):
            electrons[i] = values[i] * factor + corrected[i] * whole + offset


@compiled
def add_noise(electrons: Floats, normal: Floats, read_variance: float, gains: Floats) -> None:
    """Add photon shot noise (variance = mean) and read noise, and apply the gains, in place.

    Shot noise is Gaussian. Where the count is too small for that, the read noise of tens of
    electrons hides the difference.
    """
    for i in range(electrons.size):
        mean = electrons[i] * gains[i]
        electrons[i] = mean + np.sqrt(mean + np.float32(read_variance)) * normal[i]


@compiled
def convert_to_levels(
    electrons: Floats, full_well: float, per_electron: float, levels: npt.NDArray[np.uint16]
) -> None:
    """Clip the electrons to 0 and the full well, and round them to levels."""
    for i in range(electrons.size):
        filled = min(max(electrons[i], np.float32(0.0)), np.float32(full_well))
        levels[i] = np.uint16(filled * np.float32(per_electron) + np.float32(0.5))
