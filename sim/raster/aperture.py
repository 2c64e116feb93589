"""From fine grid to sensor pixels: the lens's blur, then the mean over each pixel's area."""

from __future__ import annotations

import math

import cv2
import numpy as np
import numpy.typing as npt

LENS_BLUR_PX = 0.35
"""Deviation of the lens's point spread [sensor px] (assumed; a third of a pixel)."""
REACH_PX = 1
"""How many pixels beyond its own a pixel sees through the blur: 2.9 deviations."""

INTERPOLATION = 1 / 6
"""Variance that linear interpolation adds to an image's blur, in squared grid spacings: f (1 − f)
for a place f of the way between two points, the mean of which is ⅙."""

F32 = npt.NDArray[np.float32]


def aperture_weights(supersample: int, blur_px: float = LENS_BLUR_PX) -> F32:
    """Share of each of a pixel's points, along one axis.

    The pixel's own points and those of its neighbours: its area, blurred by the lens.

    Args:
        supersample: points per pixel.
        blur_px: deviation of the lens's point spread; 0 for the area alone [px].

    Returns:
        (3 · supersample,) float32, which sum to 1.
    """
    point = np.arange(3 * supersample)
    own = point[supersample : 2 * supersample, None]
    deviation = max(blur_px * supersample, 1e-3)
    spread = np.exp(-0.5 * ((point - own) / deviation) ** 2)
    weights = (spread / spread.sum()).sum(axis=0)
    return np.asarray(weights / weights.sum(), np.float32)


def blur_before_interpolation_px(per_pixel: int) -> float:
    """Deviation of a blur that, interpolated on a grid of so many points a pixel, is the lens's."""
    return math.sqrt(max(LENS_BLUR_PX**2 - INTERPOLATION / per_pixel**2, 0.0))


def to_pixels(fine: F32, supersample: int, blur_px: float = LENS_BLUR_PX) -> F32:
    """What pixels see of a finely drawn image; its border goes on outside.

    Args:
        fine: (height · supersample, width · supersample) float32.
        supersample: points per pixel and axis.
        blur_px: as in `aperture_weights`.

    Returns:
        (height, width) float32.
    """
    return on_grid(fine, supersample, per_pixel=1, blur_px=blur_px)


def on_grid(fine: F32, supersample: int, *, per_pixel: int, blur_px: float = LENS_BLUR_PX) -> F32:
    """What pixels would see that lie `per_pixel` to a pixel, each as large as before.

    Args:
        fine: (height · supersample, width · supersample) float32.
        supersample: points per pixel and axis.
        per_pixel: grid points per pixel and axis; it divides `supersample`.
        blur_px: as in `aperture_weights`.

    Returns:
        (height · per_pixel, width · per_pixel) float32; point (i, j) lies at
        ((i + ½) / per_pixel, (j + ½) / per_pixel) pixels.
    """
    stride = supersample // per_pixel
    weights = aperture_weights(supersample, blur_px)
    if (supersample - stride) % 2:  # the middle falls between two points: average both
        weights = np.convolve(weights, [0.5, 0.5]).astype(np.float32)
    # Output k is centred on fine coordinate (k + ½)·stride; the kernel's middle lies at
    # len / 2 after its first point.
    anchor = (len(weights) - stride) // 2
    blurred = cv2.sepFilter2D(
        fine, -1, weights, weights, anchor=(anchor, anchor), borderType=cv2.BORDER_REPLICATE
    )
    return np.ascontiguousarray(blurred[::stride, ::stride])
