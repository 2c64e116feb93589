"""Measure the motion between two frames, and interpolate frames between them.

The sensor treats luminance as a linear ramp from one frame to the next. If an edge moves by more
than a pixel between them, this is wrong: the pixels on its way should change one after another, but
all of them change at once. The optical flow is DIS (Kroeger et al. 2016) from OpenCV. Interpolated
frames are warped from both frames along the flow at their time, as combined by Jiang et al. (2018,
"Super SloMo", equation 4), without the learned part of that method.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

F32 = npt.NDArray[np.float32]
U8 = npt.NDArray[np.uint8]

MIN_CHANGE = 3
"""Smallest change of a pixel that counts as motion, in grey levels of 255 (assumed: above the noise
of compression)."""
MIN_GRADIENT = 1.0
"""Smallest gradient along which motion is measured [grey levels/px] (assumed: optical flow is
unreliable where the image is flatter)."""
QUANTILE = 0.95
"""Quantile of the displacements that is taken as the motion, so that outliers do not count."""
MAX_INTERPOLATED = 200
"""Most frames that are interpolated between two frames (assumed)."""
GAMMA = 2.2
"""Exponent of the grey levels in which flow is computed, so that dark and bright count alike."""
DARK_CD_M2 = 1e-4
"""Luminance below which no change counts (assumed: a night sky without moon has about 2e-4)."""
MIN_CONTRAST = 100.0
"""Ratio of luminances that fills the 255 levels at least (assumed: that of a picture in daylight).
A flatter scene is not stretched further, because its noise would count as motion."""


class MotionMeter:
    """Measures optical flow between luminance frames."""

    def __init__(self, white_cd_m2: float | None) -> None:
        """Prepare the flow algorithm.

        Args:
            white_cd_m2: luminance of the highest grey level [cd/m²]; None if the luminance has any
                range.
        """
        self._white = white_cd_m2
        self._dis: Any = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)

    def flow_px(self, before: F32, after: F32) -> F32:
        """Return the displacement (x, y) of each pixel of `before`: (rows, columns, 2) [px]."""
        return np.asarray(self._dis.calc(*self._levels(before, after), None), np.float32)

    def motion_px(self, before: F32, after: F32, flow_px: F32) -> float:
        """Return the motion between two frames: a high quantile of the displacements [px].

        It takes the pixels whose luminance changed, and the flow along the image gradient. Across
        the gradient, along a bar or a stripe, motion is invisible (the aperture problem) and the
        flow is arbitrary.

        Args:
            before: (rows, columns) luminance of the first frame [cd/m²].
            after: (rows, columns) luminance of the second frame [cd/m²].
            flow_px: flow from the first to the second, as `flow_px` returns it [px].
        """
        levels = self._levels(before, after)
        gradient_x, gradient_y = (
            cv2.Sobel(levels[0], cv2.CV_32F, dx, dy, scale=1 / 8) for dx, dy in ((1, 0), (0, 1))
        )
        gradient = np.hypot(gradient_x, gradient_y)
        used = (cv2.absdiff(*levels) >= MIN_CHANGE) & (gradient > MIN_GRADIENT)
        if not used.any():
            return 0.0
        product = flow_px[..., 0] * gradient_x + flow_px[..., 1] * gradient_y
        along = product[used] / gradient[used]
        return float(np.quantile(np.abs(along), QUANTILE))

    def _levels(self, before: F32, after: F32) -> tuple[U8, U8]:
        """Return the grey levels in which motion between two frames is measured."""
        if self._white is None:
            return _log_levels(before, after)
        return _grey_levels(before, self._white), _grey_levels(after, self._white)


def _grey_levels(luminance: F32, white_cd_m2: float) -> U8:
    share = np.clip(luminance / np.float32(white_cd_m2), 0.0, 1.0)
    return np.asarray(np.rint(255 * share ** (1 / GAMMA)), np.uint8)


def _log_levels(before: F32, after: F32) -> tuple[U8, U8]:
    """Return levels that are proportional to log luminance, from the lowest to the highest.

    A scene 1000 times brighter has the same levels, except near `DARK_CD_M2`.
    """
    first, second = (np.log(luminance + np.float32(DARK_CD_M2)) for luminance in (before, after))
    low = min(first.min(), second.min())
    highest = max(first.max(), second.max())
    scale = 255 / max(float(highest - low), math.log(MIN_CONTRAST))
    return (
        np.asarray(np.rint(scale * (first - low)), np.uint8),
        np.asarray(np.rint(scale * (second - low)), np.uint8),
    )


def interpolation_count(motion_px: float, step_px: float) -> int:
    """Return how many frames to interpolate so that nothing moves more than `step_px` at once."""
    return min(MAX_INTERPOLATED, max(0, math.ceil(motion_px / step_px) - 1))


def interpolated(
    before: F32, after: F32, forward_px: F32, backward_px: F32, count: int
) -> Iterator[tuple[float, F32]]:
    """Interpolate frames at evenly spaced times between two frames.

    Args:
        before: (rows, columns) luminance of the first frame [cd/m²].
        after: (rows, columns) luminance of the second frame [cd/m²].
        forward_px: (rows, columns, 2) flow from the first to the second [px].
        backward_px: (rows, columns, 2) flow from the second to the first [px].
        count: number of frames.

    Yields:
        Time as a share of the interval, in (0, 1), and the luminance at that time.
    """
    rows, columns = before.shape
    grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=2).astype(np.float32)
    for k in range(1, count + 1):
        t = k / (count + 1)
        to_before = -(1 - t) * t * forward_px + t * t * backward_px
        to_after = (1 - t) ** 2 * forward_px - t * (1 - t) * backward_px
        mixed = (1 - t) * _warped(before, grid + to_before) + t * _warped(after, grid + to_after)
        yield t, np.asarray(mixed, np.float32)


def _warped(luminance: F32, at: npt.NDArray[Any]) -> F32:
    places = at.astype(np.float32)
    return np.asarray(
        cv2.remap(
            luminance,
            places[..., 0],
            places[..., 1],
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        ),
        np.float32,
    )
