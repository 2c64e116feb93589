"""Synthetic pictures that move to the right by any distance: a wall, a bar and a grating."""

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

F32 = npt.NDArray[np.float32]
U8 = npt.NDArray[np.uint8]


def wall(shift_px: float, *, rows: int = 130, columns: int = 173) -> F32:
    """Return a random texture, as a share of white from 0.1 to 0.9, shifted to the right."""
    rng = np.random.default_rng(0)
    texture = cv2.GaussianBlur(rng.normal(size=(rows, 3 * columns)).astype(np.float32), (0, 0), 3)
    texture = np.clip(0.5 + 0.8 * texture / np.abs(texture).max(), 0.1, 0.9)
    x = np.tile(np.arange(columns, dtype=np.float32) + columns - np.float32(shift_px), (rows, 1))
    y = np.tile(np.arange(rows, dtype=np.float32)[:, None], (1, columns))
    return np.asarray(cv2.remap(texture.astype(np.float32), x, y, cv2.INTER_CUBIC), np.float32)


def bar(shift_px: float, *, rows: int = 130, columns: int = 173) -> F32:
    """Return a vertical bar 20 px wide that fills the height, as a share of white."""
    x = np.arange(columns, dtype=np.float32) - np.float32(shift_px)
    inside = np.clip(np.minimum(x - 49.5, 70.5 - x), 0, 1)
    return np.tile(0.1 + 0.8 * inside, (rows, 1)).astype(np.float32)


def grating(shift_px: float, *, rows: int = 130, columns: int = 173) -> F32:
    """Return a vertical sine grating with a period of 40 px, as a share of white."""
    x = np.arange(columns, dtype=np.float32) - np.float32(shift_px)
    return np.tile(0.5 + 0.4 * np.sin(2 * np.pi * x / 40), (rows, 1)).astype(np.float32)


def wall_sequence(count: int, px_per_frame: float, **size: Any) -> U8:
    """Return (count, rows, columns) grey levels of a moving wall, proportional to luminance."""
    frames = [np.rint(255 * wall(k * px_per_frame, **size)) for k in range(count)]
    return np.asarray(frames, np.uint8)
