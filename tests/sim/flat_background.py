"""A level background seen from straight above, made by hand, and its composited image."""

from typing import Any

import numpy as np
import numpy.typing as npt

from sim.compositing.background import Background
from sim.compositing.canvas import blank_canvas
from sim.compositing.composite import composite
from sim.compositing.edge_pixels import aperture
from sim.compositing.pixel_labels import label_pixels
from sim.compositing.surface_lookup import Surfaces
from sim.geometry.pinhole import Intrinsics, Pose, Projection
from sim.raster.aperture import LENS_BLUR_PX
from sim.raster.scan_conversion import NO_LABEL
from sim.shadows.shadows_and_beams import ShadowsAndBeams

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]

LENS = Intrinsics(width=60, height=40, focal_px=50.0)


def pose_above(height_m: float) -> Pose:
    """Return a camera that looks straight down; image x is the world's x, image y is minus y."""
    return Pose(np.array([0.0, 0.0, height_m]), up=np.array([0.0, 1.0, 0.0]))


def flat_background(
    depth_m: float,
    layers: npt.NDArray[np.floating[Any]],
    *,
    albedo: float = 0.0,
    lens: Intrinsics = LENS,
    supersample: int = 3,
) -> Background:
    """Return a background in a plane parallel to the image.

    Args:
        depth_m: distance from the camera.
        layers: (n,) or (n, height · supersample, width · supersample) luminance of the layers
            [cd/m²]. The pixels are the layers at pixel centres, which are pixel means only where
            the luminance is even.
        albedo: luminance per lux.
        lens: intrinsics of the camera.
        supersample: sub-pixels per pixel and axis.
    """
    shape = lens.height * supersample, lens.width * supersample
    if layers.ndim == 1:
        layers = np.broadcast_to(layers[:, None, None], (len(layers), *shape))
    subpixels = np.ascontiguousarray(layers, np.float32)
    normals = np.zeros((3, lens.height, lens.width), np.float32)
    normals[2] = -1
    centre = slice(supersample // 2, None, supersample)
    return Background(
        pixels=subpixels[:, centre, centre].copy(),
        subpixels=subpixels,
        subpixel_albedo=np.full(shape, albedo, np.float32),
        subpixel_nearness=np.full(shape, 1 / depth_m, np.float32),
        nearness=np.full((lens.height, lens.width), 1 / depth_m, np.float32),
        normals=normals,
    )


def effects(*gains: float, **others: Any) -> ShadowsAndBeams:
    """Return no shadows and no beams, except for the attributes in `others`."""
    none: dict[str, Any] = {
        "gains": np.array(gains),
        "maps": np.zeros((0, 4, 4), np.float32),
        "sizes": np.zeros((0, 2), np.int64),
        "views": np.zeros((0, 3, 4)),
        "light": np.zeros(0, np.int64),
        "is_sun": np.zeros(0, np.bool_),
        "shadow_areas": np.zeros((0, 4), np.int64),
        "beams": np.zeros((0, 9)),
        "beam_areas": np.zeros((0, 4), np.int64),
        "beam_range_m": 60.0,
    }
    return ShadowsAndBeams(**(none | others))


NO_SURFACES = Surfaces(
    grid=np.empty((0, 2), np.float32),
    patches=np.zeros((1, 2, 5), np.int64),
    views=np.zeros((1, 2, 3, 4)),
    carriers=np.zeros(1, np.int32),
    key_us=np.zeros((1, 2), np.int64),
    means=np.zeros(1),
    per_pixel=1,
    matrices=np.zeros((1, 2, 3, 4)),
    weights=np.zeros((1, 2)),
)


def composited(
    background: Background,
    shadows_and_beams: ShadowsAndBeams,
    surfaces: Surfaces = NO_SURFACES,
    label: I32 | None = None,
    nearness: F32 | None = None,
    *,
    lens: Intrinsics = LENS,
    blur_px: float = LENS_BLUR_PX,
    rectangle: tuple[int, int, int, int] | None = None,
) -> F32:
    """Return the image, NaN outside the rectangle; `label` and `nearness` are the rectangle's."""
    supersample = len(background.subpixel_nearness) // lens.height
    x0, y0, x1, y1 = rectangle or (0, 0, lens.width, lens.height)
    shape = (y1 - y0) * supersample, (x1 - x0) * supersample
    gains = shadows_and_beams.gains
    canvas = blank_canvas(background)
    canvas.image[:] = np.nan
    canvas.image[y0:y1, x0:x1] = np.tensordot(gains, background.pixels, axes=1)[y0:y1, x0:x1]
    part = np.s_[y0 * supersample : y1 * supersample, x0 * supersample : x1 * supersample]
    canvas.label[part] = np.full(shape, NO_LABEL, np.int32) if label is None else label
    canvas.nearness[part] = np.ones(shape, np.float32) if nearness is None else nearness
    label_pixels(canvas.label, supersample, (x0, y0, x1, y1), canvas.pixel_label)
    composite(
        canvas,
        background,
        shadows_and_beams,
        surfaces,
        Projection(lens.focal_px, lens.width / 2, lens.height / 2),
        aperture(supersample, blur_px),
        (x0, y0, x1, y1),
    )
    return canvas.image


def half_plane_shadow(edge_px: float, light: int) -> dict[str, npt.NDArray[np.generic]]:
    """Return a sun shadow left of a column of a background 10 m away, with the sun at the camera.

    Args:
        edge_px: column of the shadow's edge.
        light: index of the light that is shadowed.
    """
    texels_per_m = 80.0  # a pixel of the background, 0.2 m, has 16
    maps = np.full((1, 700, 1020), -np.inf, np.float32)
    column = round((edge_px - LENS.width / 2) / LENS.focal_px * 10.0 * texels_per_m) + 510
    maps[0, :, :column] = 0.0
    view = np.array([[texels_per_m, 0, 0, 510], [0, texels_per_m, 0, 350], [0, 0, -1, 0]])
    return {
        "maps": maps,
        "sizes": np.array([[700, 1020]]),
        "views": view[None],
        "light": np.array([light]),
        "is_sun": np.array([True]),
        "shadow_areas": np.array([[0, 0, LENS.width, LENS.height]]),
    }
