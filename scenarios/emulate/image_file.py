"""Read one image file."""

from __future__ import annotations

import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from PIL import Image

from scenarios.emulate.picture_source import MAX_PIXELS, check_size
from scenarios.errors import ScenarioError

IMAGE_ENDINGS = frozenset(
    {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp", ".pgm", ".ppm"}
)


def read_image(file: Path) -> npt.NDArray[Any]:
    """Return an image, turned as its EXIF orientation states.

    Returns:
        (height, width) grey, or (height, width, 3) red, green, blue; uint8 or uint16.

    Raises:
        ScenarioError: too large, damaged, or not of 8 or 16 bits.
    """
    pages: Any = ()
    with suppress(OSError, cv2.error):
        check_size(file, *_size(file))
        # imread fails on a TIFF that has to be turned by a quarter, imreadmulti does not
        flags = cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR
        _, pages = cv2.imreadmulti(str(file), start=0, count=1, flags=flags)
    if len(pages) != 1 or pages[0].dtype not in (np.uint8, np.uint16):
        raise ScenarioError(
            f"{file} is not a readable image of 8 or 16 bits. Write it again, or remove it."
        )
    image: npt.NDArray[Any] = pages[0]
    return np.ascontiguousarray(image if image.ndim == 2 else image[..., ::-1])


def _size(file: Path) -> tuple[int, int]:
    """Return width and height from the header of an image, without decoding it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Image.DecompressionBombWarning)
        try:
            with Image.open(file) as header:
                width, height = header.size
        except Image.DecompressionBombError as error:
            raise ScenarioError(
                f"{file} is too large ({error}). Allowed are {MAX_PIXELS:,} pixels in all. Make it "
                "smaller."
            ) from error
    return width, height
