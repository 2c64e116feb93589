"""Pictures as light on a sensor of another size."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from emulator import luminance_of
from emulator.grey_levels import Transfer
from scenarios.errors import ScenarioError

F32 = npt.NDArray[np.float32]


def light_on(
    picture: npt.NDArray[Any],
    *,
    size: tuple[int, int],
    white_cd_m2: float,
    transfer: Transfer,
    frame: int = 0,
) -> F32:
    """Luminance of a picture, filling a sensor: the middle, in its own proportions.

    It is scaled in luminance, not in levels, as a lens would do it.

    Args:
        picture: as `Pictures` gives them.
        size: columns and rows of the sensor [px].
        white_cd_m2: luminance of the highest level [cd/m²].
        transfer: how levels stand for light.
        frame: its number, counted from 0, for what is said of it.

    Returns:
        (rows, columns) float32 [cd/m²].

    Raises:
        ScenarioError: light that is negative, NaN or infinite.
        FrameError: a white that no sensor takes.
    """
    if picture.dtype.kind == "f":
        light = _checked(picture, frame)
    else:
        light = luminance_of(picture, white_cd_m2=white_cd_m2, transfer=transfer)
    return _fitted(light, size)


def _checked(picture: npt.NDArray[Any], frame: int) -> F32:
    with np.errstate(over="ignore"):  # what float32 cannot hold is infinite there, and refused
        light = picture.astype(np.float32)
    wrong = ~(np.isfinite(light) & (light >= 0.0))
    if wrong.any():
        row, column = np.argwhere(wrong)[0].tolist()
        raise ScenarioError(
            f"the light of frame {frame} (the first is 0) is {picture[row, column]:g} cd/m² at row "
            f"{row}, column {column}; allowed is a finite number from 0 on; mend the array"
        )
    return light


def _fitted(light: F32, size: tuple[int, int]) -> F32:
    width, height = size
    rows, columns = light.shape
    scale = max(width / columns, height / rows)
    if scale != 1.0:
        wide, high = max(width, round(columns * scale)), max(height, round(rows * scale))
        how = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
        light = np.asarray(cv2.resize(light, (wide, high), interpolation=how), np.float32)
    top, left = (light.shape[0] - height) // 2, (light.shape[1] - width) // 2
    return np.ascontiguousarray(light[top : top + height, left : left + width])
