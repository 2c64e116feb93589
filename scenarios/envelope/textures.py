"""Log luminance of drawn surfaces: patches of several sizes, as paint, asphalt and leaves have."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

F32 = npt.NDArray[np.float32]

TARGET_OCTAVES_PX = (4, 8, 16, 32)
STREET_OCTAVES_PX = (2, 4, 8, 16, 32)
LEAF_OCTAVES_PX = (3, 6, 12)
"""Sides of the patches; each octave has the same share of the contrast, as natural scenes have by
and large (Field 1987)."""

STRIPE_PX = 12
"""A period of 24 px: what moves by half of it in a detector's delay seems to stand, and what moves
by more to go back, as a wheel's spokes do in a film (assumed)."""


def panels(shape: tuple[int, int], *, contrast: float, rng: np.random.Generator) -> F32:
    """A painted surface: sharp-edged panels.

    Args:
        shape: (rows, columns) [px].
        contrast: standard deviation of the log luminance.
        rng: of the patches.

    Returns:
        (rows, columns) float32 of mean 0.
    """
    return _octaves(shape, TARGET_OCTAVES_PX, cv2.INTER_NEAREST, contrast, rng)


def stripes(shape: tuple[int, int], *, contrast: float) -> F32:
    """Stripes across the columns, light and dark, `STRIPE_PX` wide each; see `panels`."""
    row = np.where(np.arange(shape[1]) // STRIPE_PX % 2, -contrast, contrast)
    return np.tile(row.astype(np.float32), (shape[0], 1))


def saloon(shape: tuple[int, int], *, contrast: float) -> tuple[F32, F32]:
    """A car seen from its side, facing right: few edges, as the simulated one has.

    Args:
        shape: (rows, columns) [px].
        contrast: standard deviation of the log luminance over the car.

    Returns:
        Log luminance and cover (1 on the car, 0 beside it), both (rows, columns) float32.
    """
    rows, columns = shape
    y, x = ((np.arange(n) + 0.5) / n for n in (rows, columns))
    y = y[:, None]
    slope = 0.25 * (0.4 - y)  # the cabin narrows towards the roof
    cabin = (x > 0.2 + slope) & (x < 0.8 - slope) & (y < 0.4)
    glass = (x > 0.24 + slope) & (x < 0.76 - slope) & (y > 0.08) & (y < 0.36)
    body = (y >= 0.4) & (y < 0.88) & (x > 0)
    paint = np.where(body | cabin, 0.5, 0.0)
    paint[glass & (abs(x - 0.5) > 0.015)] = -0.9
    paint[body & (y > 0.8)] = -0.7
    cover = body | cabin
    for hub in (0.2, 0.8):
        away = np.hypot((x - hub) * columns, (y - 0.82) * rows) / (0.18 * rows)
        paint = np.where(away < 1, np.where(away < 0.55, 0.3, -1.2), paint)
        cover |= away < 1
    paint *= contrast / paint[cover].std()
    return paint.astype(np.float32), cover.astype(np.float32)


def street(shape: tuple[int, int], *, contrast: float, rng: np.random.Generator) -> F32:
    """A still background without sharp edges; see `panels`."""
    return _octaves(shape, STREET_OCTAVES_PX, cv2.INTER_CUBIC, contrast, rng)


def leaves(shape: tuple[int, int], *, contrast: float, rng: np.random.Generator) -> F32:
    """Foliage: small, sharp-edged patches; see `panels`."""
    return _octaves(shape, LEAF_OCTAVES_PX, cv2.INTER_NEAREST, contrast, rng)


def crown(diameter_px: int, *, rng: np.random.Generator) -> F32:
    """Cover of a tree's crown: 1 inside a ragged disc, 0 outside, (diameter, diameter) float32."""
    ordinate = (np.arange(diameter_px) + 0.5) / diameter_px * 2 - 1
    radius = np.hypot(ordinate[:, None], ordinate)
    ragged = leaves((diameter_px, diameter_px), contrast=0.15, rng=rng)
    return np.asarray(radius + ragged < 0.85, np.float32)


def _octaves(
    shape: tuple[int, int],
    sides_px: tuple[int, ...],
    interpolation: int,
    contrast: float,
    rng: np.random.Generator,
) -> F32:
    rows, columns = shape
    image = np.zeros(shape, np.float32)
    for side in sides_px:
        patches = rng.standard_normal((-(-rows // side) + 1, -(-columns // side) + 1), np.float32)
        size = patches.shape[1] * side, patches.shape[0] * side
        image += cv2.resize(patches, size, interpolation=interpolation)[:rows, :columns]
    image -= image.mean()
    return np.asarray(image * (contrast / float(image.std())), np.float32)
