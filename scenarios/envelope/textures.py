"""Textures of synthetic stimuli: log luminance in patches of several sizes."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

F32 = npt.NDArray[np.float32]

TARGET_OCTAVES_PX = (4, 8, 16, 32)
BACKGROUND_OCTAVES_PX = (2, 4, 8, 16, 32)
FOLIAGE_OCTAVES_PX = (3, 6, 12)
"""Sides of the patches. Each octave contributes equally to the contrast, as in most natural scenes
(Field 1987)."""

STRIPE_PX = 12
"""Width of a stripe; the period is 24 px (assumed). Stripes that move by half a period in a
detector's delay seem to stand still, and faster ones seem to move backwards, like the spokes of a
wheel in a film."""


def panels(shape: tuple[int, int], *, contrast: float, rng: np.random.Generator) -> F32:
    """Return a painted surface of sharp-edged panels.

    Args:
        shape: (rows, columns) [px].
        contrast: standard deviation of the log luminance.
        rng: random generator for the patches.

    Returns:
        (rows, columns) float32, with mean 0.
    """
    return _octaves(shape, TARGET_OCTAVES_PX, cv2.INTER_NEAREST, contrast, rng)


def stripes(shape: tuple[int, int], *, contrast: float) -> F32:
    """Return vertical stripes, bright and dark in turn, each `STRIPE_PX` wide.

    Args:
        shape: (rows, columns) [px].
        contrast: standard deviation of the log luminance.

    Returns:
        (rows, columns) float32.
    """
    row = np.where(np.arange(shape[1]) // STRIPE_PX % 2, -contrast, contrast)
    return np.tile(row.astype(np.float32), (shape[0], 1))


def saloon_car(shape: tuple[int, int], *, contrast: float) -> tuple[F32, F32]:
    """Return a car in side view, facing right, with as few edges as the simulated one.

    Args:
        shape: (rows, columns) [px].
        contrast: standard deviation of the log luminance over the car.

    Returns:
        Log luminance and opacity (1 on the car, 0 elsewhere), both (rows, columns) float32.
    """
    rows, columns = shape
    y, x = ((np.arange(n) + 0.5) / n for n in (rows, columns))
    y = y[:, None]
    slope = 0.25 * (0.4 - y)  # the cabin narrows towards the roof
    cabin = (x > 0.2 + slope) & (x < 0.8 - slope) & (y < 0.4)
    glass = (x > 0.24 + slope) & (x < 0.76 - slope) & (y > 0.08) & (y < 0.36)
    body = (y >= 0.4) & (y < 0.88) & (x > 0)
    texture = np.where(body | cabin, 0.5, 0.0)
    texture[glass & (abs(x - 0.5) > 0.015)] = -0.9
    texture[body & (y > 0.8)] = -0.7
    opacity = body | cabin
    for hub in (0.2, 0.8):
        away = np.hypot((x - hub) * columns, (y - 0.82) * rows) / (0.18 * rows)
        texture = np.where(away < 1, np.where(away < 0.55, 0.3, -1.2), texture)
        opacity |= away < 1
    texture *= contrast / texture[opacity].std()
    return texture.astype(np.float32), opacity.astype(np.float32)


def rotated(texture: F32, opacity: F32, clockwise_deg: float) -> tuple[F32, F32]:
    """Return a layer rotated about its centre, in the smallest rectangle that holds it.

    Args:
        texture: log luminance, (rows, columns) float32.
        opacity: its opacity, the same shape.
        clockwise_deg: angle of the rotation, clockwise in the image [deg].

    Returns:
        Log luminance and opacity, (rows, columns) float32; the opacity falls from 1 to 0 within a
        pixel of the edges.
    """
    rows, columns = texture.shape
    matrix = cv2.getRotationMatrix2D(((columns - 1) / 2, (rows - 1) / 2), -clockwise_deg, 1.0)
    turn = np.abs(matrix[:, :2])
    width, height = (int(np.ceil(v)) + 2 for v in turn @ (columns, rows))
    matrix[:, 2] += (width - columns) / 2, (height - rows) / 2
    turned, covered = (
        np.asarray(cv2.warpAffine(image, matrix, (width, height), borderMode=border), np.float32)
        for image, border in ((texture, cv2.BORDER_REPLICATE), (opacity, cv2.BORDER_CONSTANT))
    )
    return turned, covered


def smooth_background(shape: tuple[int, int], *, contrast: float, rng: np.random.Generator) -> F32:
    """Return a background without sharp edges; arguments and result are those of `panels`."""
    return _octaves(shape, BACKGROUND_OCTAVES_PX, cv2.INTER_CUBIC, contrast, rng)


def foliage(shape: tuple[int, int], *, contrast: float, rng: np.random.Generator) -> F32:
    """Return small, sharp-edged patches; arguments and result are those of `panels`."""
    return _octaves(shape, FOLIAGE_OCTAVES_PX, cv2.INTER_NEAREST, contrast, rng)


def tree_crown(diameter_px: int, *, rng: np.random.Generator) -> F32:
    """Return the opacity of a tree's crown: 1 inside a ragged disc, 0 outside.

    Args:
        diameter_px: diameter of the crown [px].
        rng: random generator for its edge.

    Returns:
        (diameter, diameter) float32.
    """
    ordinate = (np.arange(diameter_px) + 0.5) / diameter_px * 2 - 1
    radius = np.hypot(ordinate[:, None], ordinate)
    ragged = foliage((diameter_px, diameter_px), contrast=0.15, rng=rng)
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
