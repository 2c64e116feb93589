"""Grey levels as light: 8- and 16-bit images to the luminance that the sensor takes."""

from __future__ import annotations

from numbers import Real
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from emulator.errors import FrameError
from emulator.luminance_frames import MAX_LUMINANCE_CD_M2

Transfer = Literal["srgb", "linear"]
"""How levels stand for light: `srgb` as cameras and displays encode it (IEC 61966-2-1), `linear`
in proportion."""

_WEIGHTS = np.array([0.2126, 0.7152, 0.0722])
"""Luminance of the red, green and blue primaries of sRGB (IEC 61966-2-1)."""


def luminance_of(
    image: npt.NDArray[np.uint8] | npt.NDArray[np.uint16],
    *,
    white_cd_m2: float,
    transfer: Transfer = "srgb",
) -> npt.NDArray[np.float32]:
    """Luminance of an image whose white is known.

    Args:
        image: (height, width) grey, or (height, width, 3) red, green, blue; uint8 or uint16.
        white_cd_m2: luminance that the highest level stands for [cd/m²]; 100 to 300 on a display,
            2000 to 10 000 on paper in daylight.
        transfer: how levels stand for light.

    Returns:
        (height, width) float32 [cd/m²].

    Raises:
        FrameError: no array, another dtype or shape, a white that is not positive or above
            `MAX_LUMINANCE_CD_M2`, or another transfer function.
    """
    if not isinstance(image, np.ndarray):
        raise FrameError(
            f"the image is a {type(image).__name__}; allowed is an array of uint8 or uint16; "
            "convert it with np.asarray(image, np.uint8)"
        )
    if image.dtype not in (np.uint8, np.uint16):
        raise FrameError(
            f"the image has dtype {image.dtype}; allowed is uint8 or uint16; convert it, or pass "
            "luminance in cd/m² to the sensor as it is"
        )
    if image.ndim != 2 and not (image.ndim == 3 and image.shape[2] == 3):
        raise FrameError(
            f"the image has shape {image.shape}; allowed is (height, width) or (height, width, 3); "
            "drop the alpha channel or pass one image at a time"
        )
    numeric = isinstance(white_cd_m2, Real) and not isinstance(white_cd_m2, bool)
    if not numeric or not 0.0 < white_cd_m2 <= MAX_LUMINANCE_CD_M2:
        raise FrameError(
            f"white_cd_m2 is {white_cd_m2!r}; allowed is a positive number up to "
            f"{MAX_LUMINANCE_CD_M2:g}; give the luminance of the highest level, such as 200"
        )
    if transfer not in get_args(Transfer):
        raise FrameError(
            f"the transfer function is {transfer!r}; allowed is one of "
            f"{', '.join(get_args(Transfer))}; images from cameras are srgb as a rule"
        )
    table = _levels(np.iinfo(image.dtype).max, transfer) * float(white_cd_m2)
    light = table[image]
    return np.asarray(light @ _WEIGHTS if image.ndim == 3 else light, np.float32)


def _levels(highest: int, transfer: Transfer) -> npt.NDArray[np.float64]:
    """Share of white of each level, from 0 to `highest`."""
    share = np.arange(highest + 1) / highest
    if transfer == "linear":
        return share
    curve = ((share + 0.055) / 1.055) ** 2.4
    return np.where(share <= 0.04045, share / 12.92, curve)
