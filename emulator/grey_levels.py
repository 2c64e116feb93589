"""Conversion of 8- and 16-bit images to luminance, as the sensor takes it."""

from __future__ import annotations

from numbers import Real
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from emulator.errors import FrameError
from emulator.luminance_frames import MAX_LUMINANCE_CD_M2

Transfer = Literal["srgb", "linear"]
"""How levels encode luminance: `srgb` as cameras and displays do (IEC 61966-2-1), or `linear`."""

_WEIGHTS = np.array([0.2126, 0.7152, 0.0722])
"""Luminance of the red, green and blue primaries of sRGB (IEC 61966-2-1)."""


def luminance_of(
    image: npt.NDArray[np.uint8] | npt.NDArray[np.uint16],
    *,
    white_cd_m2: float,
    transfer: Transfer = "srgb",
) -> npt.NDArray[np.float32]:
    """Return the luminance of an image.

    Args:
        image: (height, width) grey, or (height, width, 3) red, green, blue; uint8 or uint16.
        white_cd_m2: luminance of the highest level [cd/m²]; 100 to 300 on a display, 2000 to 10 000
            on paper in daylight.
        transfer: how levels encode luminance.

    Returns:
        (height, width) float32 [cd/m²].

    Raises:
        FrameError: no array, another dtype or shape, a white that is not positive or above
            `MAX_LUMINANCE_CD_M2`, or another transfer function.
    """
    _check_image(image)
    numeric = isinstance(white_cd_m2, Real) and not isinstance(white_cd_m2, bool)
    if not numeric or not 0.0 < white_cd_m2 <= MAX_LUMINANCE_CD_M2:
        raise FrameError(
            f"white_cd_m2 is {white_cd_m2!r}. Allowed is a positive number up to "
            f"{MAX_LUMINANCE_CD_M2:g}. Give the luminance of the highest level, such as 200."
        )
    if transfer not in get_args(Transfer):
        raise FrameError(
            f"the transfer function is {transfer!r}. Allowed is one of "
            f"{', '.join(get_args(Transfer))}. Choose srgb for images from cameras."
        )
    table = _relative_luminance(np.iinfo(image.dtype).max, transfer) * float(white_cd_m2)
    luminance = table[image]
    return np.asarray(luminance @ _WEIGHTS if image.ndim == 3 else luminance, np.float32)


def _check_image(image: Any) -> None:
    if not isinstance(image, np.ndarray):
        raise FrameError(
            f"the image is a {type(image).__name__}. Allowed is an array of uint8 or uint16. "
            "Convert it with np.asarray(image, np.uint8)."
        )
    if image.dtype not in (np.uint8, np.uint16):
        raise FrameError(
            f"the image has dtype {image.dtype}. Allowed is uint8 or uint16. Convert it, or pass "
            "luminance in cd/m² to the sensor directly."
        )
    if image.ndim != 2 and not (image.ndim == 3 and image.shape[2] == 3):
        raise FrameError(
            f"the image has shape {image.shape}. Allowed is (height, width) or (height, width, 3). "
            "Drop the alpha channel, or pass one image at a time."
        )


def _relative_luminance(highest: int, transfer: Transfer) -> npt.NDArray[np.float64]:
    """Return the luminance of each level from 0 to `highest`, as a fraction of white."""
    level = np.arange(highest + 1) / highest
    if transfer == "linear":
        return level
    curve = ((level + 0.055) / 1.055) ** 2.4
    return np.where(level <= 0.04045, level / 12.92, curve)
