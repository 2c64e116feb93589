"""Convert a picture to luminance on the pixels of a sensor."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from emulator import luminance_of
from emulator.grey_levels import Transfer
from scenarios.errors import ScenarioError

F32 = npt.NDArray[np.float32]


def sensor_luminance(
    picture: npt.NDArray[Any],
    *,
    size: tuple[int, int],
    white_cd_m2: float,
    transfer: Transfer,
    frame: int = 0,
) -> F32:
    """Return the luminance of a picture, scaled and cropped to fill a sensor.

    The aspect ratio is kept, and the middle of the picture fills the sensor. Luminance is
    interpolated, not grey levels, as a lens would do.

    Args:
        picture: one of the arrays that `Pictures` yields.
        size: columns and rows of the sensor [px].
        white_cd_m2: luminance of the highest grey level [cd/m²].
        transfer: relation of grey levels to luminance.
        frame: number of the picture, counted from 0, for error messages.

    Returns:
        (rows, columns) float32 luminance [cd/m²].

    Raises:
        ScenarioError: a luminance is negative, NaN or infinite.
        FrameError: `white_cd_m2` is out of range.
    """
    if picture.dtype.kind == "f":
        luminance = _checked(picture, frame)
    else:
        luminance = luminance_of(picture, white_cd_m2=white_cd_m2, transfer=transfer)
    return _fitted(luminance, size)


def _checked(picture: npt.NDArray[Any], frame: int) -> F32:
    with np.errstate(over="ignore"):  # values too large for float32 become infinite
        luminance = picture.astype(np.float32)
    wrong = ~(np.isfinite(luminance) & (luminance >= 0.0))
    if wrong.any():
        row, column = np.argwhere(wrong)[0].tolist()
        raise ScenarioError(
            f"The luminance of frame {frame} (counted from 0) is {picture[row, column]:g} cd/m² at "
            f"row {row}, column {column}. Allowed is a finite number, 0 or more. Correct the array."
        )
    return luminance


def _fitted(luminance: F32, size: tuple[int, int]) -> F32:
    width, height = size
    rows, columns = luminance.shape
    scale = max(width / columns, height / rows)
    if scale != 1.0:
        wide, high = max(width, round(columns * scale)), max(height, round(rows * scale))
        method = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
        resized = cv2.resize(luminance, (wide, high), interpolation=method)
        luminance = np.asarray(resized, np.float32)
    top, left = (luminance.shape[0] - height) // 2, (luminance.shape[1] - width) // 2
    return np.ascontiguousarray(luminance[top : top + height, left : left + width])
