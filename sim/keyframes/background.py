"""The still street, taken apart by light, so that it can be lit anew without being drawn anew.

Light is linear: what the camera sees is the sum of what each lamp adds. So the street is drawn
once with all lamps, once without those that cast shadows, once with each of these alone, and never
again; a passing shadow takes its share from its own lamp alone. What is left where all are shut
out is drawn as such: as a difference it would be as rough as the renderer's rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import NEAR_M, Intrinsics, Pose
from sim.geometry.rectangles import Rectangle
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.raster.aperture import to_pixels
from sim.raster.scan_conversion import empty_buffer, perspective, rasterise
from sim.raster.triangles import Soup, unit_normals
from sim.render.filament import FilamentRenderer
from sim.scene.lamp_flicker import FlickeringLamps, changed_lights, sky_lights

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
Numbers = npt.NDArray[np.int64]

FAR = 1e-6
"""Nearness of what is at no distance, such as the sky [1/m] (assumed)."""


class Background(NamedTuple):
    """What never moves, by light.

    Attributes:
        pixels: (1 + lights, height, width) float32 [cd/m²]: what comes steadily, then what each
            light that casts shadows adds where nothing is in its way.
        points: the same on the fine grid, but (rows, columns, 1 + lights): they are read point by
            point.
        albedo_points: fine grid, float32 [cd/m² a lux].
        nearness: fine grid, 1/depth [1/m], float32.
        depth: (height, width) float32 at the pixels' middles [m].
        normals: (height, width, 3) float32 at the pixels' middles, in the camera's frame.
    """

    pixels: F32
    points: F32
    albedo_points: F32
    nearness: F32
    depth: F32
    normals: F32


def render_background(
    renderer: FilamentRenderer,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    pose: Pose,
    soup: Soup,
    shadowing: Numbers,
    mains: FlickeringLamps | None,
    rectangle: Rectangle,
    supersample: int,
    blur_px: float,
    finer: int = 1,
    *,
    with_albedo: bool = True,
) -> Background:
    """Draw what never moves, light by light.

    Args:
        renderer: of `model`, with all that moves hidden and its lamps off.
        model: its lights are changed, and put back.
        data: where the still things are.
        pose: the camera's.
        soup: the triangles of what never moves.
        shadowing: (lights,) numbers of the lights in whose way movers can be.
        mains: what flickers; its glow makes a last part.
        rectangle: what shadows and beams can reach; elsewhere the lights are not told apart.
        supersample: fine points per pixel and axis.
        blur_px: deviation of the lens's point spread [px].
        finer: each fine point is the mean of so many drawn along each axis.
        with_albedo: whether movers have lamps; else nobody asks for it, and it is left at 0.
    """
    lens = renderer.intrinsics

    def drawn(which: Rectangle) -> F32:
        renderer.update(data)
        return _averaged(renderer.subpixel_luminance(pose, which, finer * supersample), finer)

    everything = (0, 0, lens.width, lens.height)
    whole = drawn(everything)
    points = np.zeros((1 + len(shadowing) + (mains is not None), *whole.shape), np.float32)
    points[0] = whole
    box = tuple(
        slice(supersample * a, supersample * b) for a, b in (rectangle[1::2], rectangle[::2])
    )
    if mains is not None:
        with mains.scaled(model, 0.0):
            points[0] = np.minimum(drawn(everything), whole)
        points[-1] = whole - points[0]
    dark: dict[int, float] = dict.fromkeys((int(k) for k in shadowing), 0.0)
    if dark:
        with changed_lights(model, dark):
            points[0][box] = rest = drawn(rectangle)
        for light, part in zip(list(dark)[1:], points[2:], strict=False):
            without = {k: v for k, v in dark.items() if k != light}
            with changed_lights(model, without):
                part[box] = np.maximum(drawn(rectangle) - rest, 0.0)
        others = points[2 : 1 + len(dark)].sum(axis=0)[box]
        points[1][box] = np.maximum(whole[box] - rest - others, 0.0)
        if mains is not None:
            with changed_lights(model, dark), mains.scaled(model, 0.0):
                points[0][box] = np.minimum(drawn(rectangle), rest)
            points[-1][box] = rest - points[0][box]
    albedo = np.zeros(whole.shape, np.float32)
    if with_albedo:
        albedo[box] = _albedo(model, lambda: drawn(rectangle))
    nearness, depth, normals = _shape(lens, data, pose, soup, supersample)
    return Background(
        pixels=np.stack([to_pixels(part, supersample, blur_px) for part in points]),
        points=np.ascontiguousarray(np.moveaxis(points, 0, -1)),
        albedo_points=albedo,
        nearness=nearness,
        depth=depth,
        normals=normals,
    )


def _averaged(fine: F32, count: int) -> F32:
    """Means of squares of `count` × `count` points."""
    if count == 1:
        return fine
    size = fine.shape[1] // count, fine.shape[0] // count
    return np.asarray(cv2.resize(fine, size, interpolation=cv2.INTER_AREA), np.float32)


def _albedo(model: mujoco.MjModel, drawn: Callable[[], F32]) -> F32:
    """Luminance of each fine point a lux on it [cd/m² a lux].

    The sky is everywhere alike, so that a surface returns its light whichever way it faces.
    """
    sky = sky_lights(model)
    if not sky.size:
        return np.zeros_like(drawn())
    dark: dict[int, float] = dict.fromkeys(range(model.nlight), 0.0)
    with changed_lights(model, dark):
        glow = drawn()
    with changed_lights(model, dark | {int(sky[0]): 1.0}):
        return np.asarray(np.maximum(drawn() - glow, 0.0) / np.float32(math.pi), np.float32)


def _shape(
    lens: Intrinsics, data: mujoco.MjData, pose: Pose, soup: Soup, supersample: int
) -> tuple[F32, F32, F32]:
    """Nearness of the fine points; depth and normals, in the camera's frame, at pixels' middles."""
    nearness = street_nearness(lens, data, pose, soup, supersample)
    seen = soup.moved(compose_transforms(body_poses(data), pose.into))
    middles, label = draw_triangles(seen, lens, 1)
    normals = np.concatenate([unit_normals(seen), np.zeros((1, 3))])[label]
    depth = np.asarray(1 / np.maximum(middles, np.float32(FAR)), np.float32)
    return nearness, depth, normals.astype(np.float32)


def street_nearness(
    lens: Intrinsics, data: mujoco.MjData, pose: Pose, soup: Soup, supersample: int
) -> F32:
    """Nearness of what never moves at the fine points of the whole image, float32 [1/m].

    Args:
        lens: the camera's.
        data: where the still things are.
        pose: the camera's.
        soup: the triangles of what never moves.
        supersample: points per pixel and axis.
    """
    seen = soup.moved(compose_transforms(body_poses(data), pose.into))
    nearness, _ = draw_triangles(seen, lens, supersample)
    return np.maximum(nearness, np.float32(FAR))


def draw_triangles(seen: F64, lens: Intrinsics, supersample: int) -> tuple[F32, I32]:
    """Nearness [1/m] and number of the triangle at each fine point of the whole image.

    Args:
        seen: (n, 3, 3) triangles in the camera's frame [m].
        lens: the camera's.
        supersample: points per pixel and axis.
    """
    nearness, label = empty_buffer(lens.height * supersample, lens.width * supersample)
    middle = lens.width * supersample / 2, lens.height * supersample / 2
    flat, source = perspective(seen, lens.focal_px * supersample, *middle, NEAR_M)
    rasterise(flat, source, 0, 0, nearness, label, True)
    return nearness, label
