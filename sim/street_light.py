"""The still street, taken apart by light, so that it can be lit anew without being drawn anew.

Light is linear: what the camera sees is the sum of what each lamp adds. So the street is drawn
once with all lamps, once without each that casts shadows, and never again; a passing shadow takes
its share from its own lamp alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import numpy.typing as npt

from sim.aperture import to_pixels
from sim.camera import Intrinsics, Pose
from sim.compose import Street
from sim.mains import Mains, changed_lights
from sim.moves import body_poses, followed_by, into_camera
from sim.raster import empty_buffer, perspective, rasterise
from sim.renderer import NEAR_M, FilamentRenderer
from sim.triangles import Soup, unit_normals
from sim.windows import Window

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
Numbers = npt.NDArray[np.int64]

FAR = 1e-6
"""Nearness of what is at no distance, such as the sky [1/m]."""


def draw_street(
    renderer: FilamentRenderer,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    pose: Pose,
    soup: Soup,
    shadowing: Numbers,
    mains: Mains | None,
    window: Window,
    supersample: int,
    blur_px: float,
) -> Street:
    """Draw what never moves, light by light.

    Args:
        renderer: of `model`, with all that moves hidden and its lamps off.
        model: its lights are changed, and put back.
        data: where the still things are.
        pose: the camera's.
        soup: the triangles of what never moves.
        shadowing: (lights,) numbers of the lights in whose way movers can be.
        mains: what flickers; its glow makes a last part.
        window: what shadows and beams can reach; elsewhere the lights are not told apart.
        supersample: fine points per pixel and axis.
        blur_px: deviation of the lens's point spread [px].
    """
    lens = renderer.intrinsics

    def drawn(which: Window) -> F32:
        renderer.update(data)
        return renderer.fine(pose, which, supersample)

    steady = drawn((0, 0, lens.width, lens.height))
    points = np.zeros((1 + len(shadowing) + (mains is not None), *steady.shape), np.float32)
    points[0] = steady
    box = tuple(slice(supersample * a, supersample * b) for a, b in (window[1::2], window[::2]))
    for part, light in zip(points[1:], shadowing, strict=False):
        with changed_lights(model, {int(light): 0.0}):
            part[box] = np.maximum(steady[box] - drawn(window), 0.0)
        points[0] -= part
    if mains is not None:
        with mains.scaled(model, 0.0):
            points[-1] = np.maximum(steady - drawn((0, 0, lens.width, lens.height)), 0.0)
        points[0] -= points[-1]
        for part, light in zip(points[1:-1], shadowing, strict=True):
            if light in mains.lights:  # told apart already
                points[-1] -= part
                points[0] += part
    np.maximum(points, 0.0, out=points)
    albedo = np.zeros_like(steady)
    albedo[box] = _albedo(model, lambda: drawn(window))
    nearness, depth, normals = _shape(lens, data, pose, soup, supersample)
    return Street(
        pixels=np.stack([to_pixels(part, supersample, blur_px) for part in points]),
        points=np.ascontiguousarray(np.moveaxis(points, 0, -1)),
        albedo_points=albedo,
        nearness=nearness,
        depth=depth,
        normals=normals,
    )


def _albedo(model: mujoco.MjModel, drawn: Callable[[], F32]) -> F32:
    """Luminance of each fine point a lux on it [cd/m² a lux].

    The sky is everywhere alike, so that a surface returns its light whichever way it faces.
    """
    sky = np.flatnonzero(model.light_type == mujoco.mjtLightType.mjLIGHT_IMAGE)
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
    seen = soup.moved(followed_by(body_poses(data), into_camera(pose)))
    nearness, _ = draw_triangles(seen, lens, supersample)
    middles, label = draw_triangles(seen, lens, 1)
    normals = np.concatenate([unit_normals(seen), np.zeros((1, 3))])[label]
    depth = np.asarray(1 / np.maximum(middles, np.float32(FAR)), np.float32)
    return np.maximum(nearness, np.float32(FAR)), depth, normals.astype(np.float32)


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
