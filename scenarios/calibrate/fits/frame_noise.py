"""Noise of the frames, from pixels that do not change between two frames."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from scenarios.calibrate.recording import CalibrationRecording

_LEAST_NOISE_DN = 1.0
_FEWEST = 100
"""Fewest pixels of a class of levels."""
_LEVELS = (0, 8, 16, 32, 64, 128, 256, 512)
"""Lower edges of the classes of levels [DN]."""

F64 = npt.NDArray[np.float64]


def frame_noise(recording: CalibrationRecording) -> list[F64]:
    """Return the noise of each pixel in each frame but the last [DN].

    In each class of levels, it is that of the pair of frames that differ the least.
    """
    images = [frame.image.astype(np.float64) for frame in recording.frames]
    edges = [*_LEVELS, np.inf]
    least = np.full(len(_LEVELS), np.inf)
    for k in range(len(images) - 1):
        ratio = recording.lux_per_level[k + 1] / recording.lux_per_level[k]
        difference = (images[k + 1] * ratio - images[k]) / np.hypot(1.0, ratio)
        for level, (low, high) in enumerate(pairwise(edges)):
            inside = (images[k] >= low) & (images[k] < min(high, recording.saturation))
            if np.count_nonzero(inside) >= _FEWEST:
                values = difference[inside]
                spread = 1.4826 * float(np.median(np.abs(values - np.median(values))))
                least[level] = min(least[level], spread)
    known = np.isfinite(least)
    centres = np.array([1.4 * low for low in _LEVELS])
    if not known.any():
        return [np.full_like(image, _LEAST_NOISE_DN) for image in images[:-1]]
    spreads = np.maximum(least[known], _LEAST_NOISE_DN)
    return [np.interp(image, centres[known], spreads) for image in images[:-1]]
