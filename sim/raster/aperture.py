"""Reduce the sub-pixel grid to sensor pixels: lens blur, then the mean over the pixel's area."""

from __future__ import annotations

import math

import cv2
import numpy as np
import numpy.typing as npt

LENS_BLUR_PX = 0.35
"""Standard deviation of the lens's point spread [sensor px] (assumed; a third of a pixel)."""
BLUR_REACH_PX = 1
"""Number of neighbouring pixels that contribute to a pixel through the lens blur, in each
direction. This cuts the point spread off at 2.9 standard deviations."""

INTERPOLATION_VARIANCE = 1 / 6
"""Variance that linear interpolation adds to an image's blur, in squared grid spacings. It is
f (1 − f) at a fraction f of the way between two grid points; the mean of that is ⅙."""

F32 = npt.NDArray[np.float32]


def aperture_weights(supersample: int, blur_px: float = LENS_BLUR_PX) -> F32:
    """Return the weight of each sub-pixel in a pixel's aperture, along one axis.

    The aperture is the pixel's area, blurred by the lens. It extends over the pixel's own
    sub-pixels and those of the neighbouring pixels on both sides.

    Args:
        supersample: sub-pixels per pixel.
        blur_px: standard deviation of the lens's point spread [px]; 0 for the area alone.

    Returns:
        (3 · supersample,) float32, with a sum of 1.
    """
    subpixel = np.arange(3 * supersample)
    own = subpixel[supersample : 2 * supersample, None]
    deviation = max(blur_px * supersample, 1e-3)
    spread = np.exp(-0.5 * ((subpixel - own) / deviation) ** 2)
    weights = (spread / spread.sum()).sum(axis=0)
    return np.asarray(weights / weights.sum(), np.float32)


def blur_before_interpolation_px(per_pixel: int) -> float:
    """Return the blur that linear interpolation completes to the lens's blur.

    Args:
        per_pixel: points per pixel and axis of the grid that is interpolated.

    Returns:
        Standard deviation [px].
    """
    return math.sqrt(max(LENS_BLUR_PX**2 - INTERPOLATION_VARIANCE / per_pixel**2, 0.0))


def to_pixels(image: F32, supersample: int, blur_px: float = LENS_BLUR_PX) -> F32:
    """Reduce a sub-pixel image to pixels. The border values continue outside the image.

    Args:
        image: (height · supersample, width · supersample) float32.
        supersample: sub-pixels per pixel and axis.
        blur_px: as in `aperture_weights`.

    Returns:
        (height, width) float32.
    """
    return to_grid(image, supersample, per_pixel=1, blur_px=blur_px)


def to_grid(image: F32, supersample: int, *, per_pixel: int, blur_px: float = LENS_BLUR_PX) -> F32:
    """Reduce a sub-pixel image to a coarser grid whose points see a whole pixel's aperture each.

    Args:
        image: (height · supersample, width · supersample) float32.
        supersample: sub-pixels per pixel and axis.
        per_pixel: grid points per pixel and axis; a divisor of `supersample`.
        blur_px: as in `aperture_weights`.

    Returns:
        (height · per_pixel, width · per_pixel) float32. Point (i, j) lies at
        ((i + ½) / per_pixel, (j + ½) / per_pixel) pixels.
    """
    stride = supersample // per_pixel
    weights = aperture_weights(supersample, blur_px)
    if (supersample - stride) % 2:  # the centre falls between two sub-pixels: average both
        weights = np.convolve(weights, [0.5, 0.5]).astype(np.float32)
    # Output k is centred on sub-pixel coordinate (k + ½)·stride. The kernel's centre lies len / 2
    # after its first sub-pixel.
    anchor = (len(weights) - stride) // 2
    blurred = cv2.sepFilter2D(
        image, -1, weights, weights, anchor=(anchor, anchor), borderType=cv2.BORDER_REPLICATE
    )
    return np.ascontiguousarray(blurred[::stride, ::stride])
