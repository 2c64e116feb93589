"""Conversion between linear values and sRGB (IEC 61966-2-1)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]


def encoded(linear: npt.ArrayLike) -> F64:
    """Convert linear values, 0 to 1, to sRGB, 0 to 1."""
    value = np.clip(np.asarray(linear, np.float64), 0.0, 1.0)
    return np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)


def decoded(code: npt.ArrayLike) -> F64:
    """Convert sRGB values, 0 to 1, to linear values, 0 to 1."""
    value = np.clip(np.asarray(code, np.float64), 0.0, 1.0)
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
