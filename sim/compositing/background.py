"""The static background as kernels see it: layers of light, and geometry."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

F32 = npt.NDArray[np.float32]


class Background(NamedTuple):
    """The static background, as layers of light and geometry.

    Layer 0 is the luminance from all lights that neither cast shadows of moving objects nor
    flicker. Then follows one layer for each light that casts shadows: the luminance that it adds if
    no moving object blocks it. The last layer is that of the flickering lamps, if there are any.

    Attributes:
        pixels: (layers, height, width) float32 luminance [cd/m²].
        subpixels: (layers, rows, columns) float32 luminance of the sub-pixels [cd/m²].
        subpixel_albedo: (rows, columns) float32 luminance per illuminance [cd/m² per lux].
        subpixel_nearness: (rows, columns) float32 1/depth [1/m].
        nearness: (height, width) float32 1/depth at the pixel centres [1/m].
        normals: (3, height, width) float32 unit normals at the pixel centres, in the camera's
            frame.
    """

    pixels: F32
    subpixels: F32
    subpixel_albedo: F32
    subpixel_nearness: F32
    nearness: F32
    normals: F32
