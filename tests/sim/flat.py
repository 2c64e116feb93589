"""A level street made by hand, seen from straight above, and nothing else unless it is given."""

from typing import Any

import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import Eye, Intrinsics, Pose
from sim.keyframes.background import Background
from sim.keyframes.compositing import compose
from sim.keyframes.surface_lookup import Surfaces
from sim.raster.aperture import LENS_BLUR_PX, aperture_weights
from sim.raster.scan_conversion import NOTHING
from sim.shadows.moving_light import Lights

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]

LENS = Intrinsics(width=60, height=40, focal_px=50.0)


def above(height_m: float) -> Pose:
    """A camera that looks straight down; image x is the world's x, image y against its y."""
    return Pose(np.array([0.0, 0.0, height_m]), up=np.array([0.0, 1.0, 0.0]))


def flat_street(
    depth_m: float,
    parts: npt.NDArray[np.floating[Any]],
    *,
    albedo: float = 0.0,
    lens: Intrinsics = LENS,
    size: int = 3,
) -> Background:
    """A street in the image's plane.

    Args:
        depth_m: from the camera.
        parts: (n,) or (n, height · size, width · size) [cd/m²]; these are pixel means only where
            they are even.
        albedo: luminance a lux.
        lens: the camera's.
        size: fine points per pixel and axis.
    """
    fine = lens.height * size, lens.width * size
    if parts.ndim == 1:
        parts = np.broadcast_to(parts[:, None, None], (len(parts), *fine))
    points = np.ascontiguousarray(parts, np.float32)
    normals = np.zeros((lens.height, lens.width, 3), np.float32)
    normals[..., 2] = -1
    middle = size // 2
    return Background(
        pixels=points[:, middle::size, middle::size].copy(),
        points=np.ascontiguousarray(np.moveaxis(points, 0, -1)),
        albedo_points=np.full(fine, albedo, np.float32),
        nearness=np.full(fine, 1 / depth_m, np.float32),
        depth=np.full((lens.height, lens.width), depth_m, np.float32),
        normals=normals,
    )


def lights(*gains: float, **others: Any) -> Lights:
    """Lights without shadows or beams, but for what `others` says."""
    none: dict[str, Any] = {
        "gains": np.array(gains),
        "maps": np.zeros((0, 4, 4), np.float32),
        "sizes": np.zeros((0, 2), np.int64),
        "views": np.zeros((0, 3, 4)),
        "light": np.zeros(0, np.int64),
        "parallel": np.zeros(0, np.bool_),
        "reach": np.zeros((0, 4), np.int64),
        "beams": np.zeros((0, 9)),
        "beam_reach": np.zeros((0, 4), np.int64),
        "beam_range_m": 60.0,
    }
    return Lights(**(none | others))


NO_SURFACES = Surfaces(
    light=np.empty(0, np.float32),
    cover=np.empty(0, np.float32),
    pieces=np.zeros((1, 2, 5), np.int64),
    moves=np.zeros((2, 3, 4)),
    shares=np.zeros((1, 2)),
    means=np.zeros(1),
    per_pixel=1,
)


def composed(
    street: Background,
    light: Lights,
    surfaces: Surfaces = NO_SURFACES,
    label: I32 | None = None,
    nearness: F32 | None = None,
    *,
    lens: Intrinsics = LENS,
    blur_px: float = LENS_BLUR_PX,
    rectangle: tuple[int, int, int, int] | None = None,
) -> F32:
    """The image, nan outside of the rectangle; `label` and `nearness` are the rectangle's."""
    size = len(street.nearness) // lens.height
    x0, y0, x1, y1 = rectangle or (0, 0, lens.width, lens.height)
    fine = (y1 - y0) * size, (x1 - x0) * size
    image = np.full((lens.height, lens.width), np.nan, np.float32)
    compose(
        image,
        street,
        light,
        surfaces,
        Eye(lens.focal_px, lens.width / 2, lens.height / 2),
        np.full(fine, NOTHING, np.int32) if label is None else label,
        np.ones(fine, np.float32) if nearness is None else nearness,
        aperture_weights(size, blur_px),
        (x0, y0, x1, y1),
    )
    return image


def half_shadow(edge_px: float, light: int) -> dict[str, npt.NDArray[np.generic]]:
    """A shadow in parallel light along the view: dark left of a column of a street 10 m off."""
    texels_m = 80.0  # a metre, so that a pixel of the street, 0.2 m, is 16
    maps = np.full((1, 700, 1020), -np.inf, np.float32)
    column = round((edge_px - LENS.width / 2) / LENS.focal_px * 10.0 * texels_m) + 510
    maps[0, :, :column] = 0.0
    view = np.array([[texels_m, 0, 0, 510], [0, texels_m, 0, 350], [0, 0, -1, 0]])
    return {
        "maps": maps,
        "sizes": np.array([[700, 1020]]),
        "views": view[None],
        "light": np.array([light]),
        "parallel": np.array([True]),
        "reach": np.array([[0, 0, LENS.width, LENS.height]]),
    }
