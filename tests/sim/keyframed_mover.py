"""A moving body in front of a level background, as seen in two synthetic keyframes."""

from collections.abc import Callable
from concurrent.futures import Future

import numpy as np
import numpy.typing as npt

from sim.compositing.surface_lookup import Surfaces
from sim.geometry.pinhole import Projection
from sim.keyframes.store import Keyframe, KeyframeStore, cut_patches
from sim.raster.aperture import LENS_BLUR_PX
from sim.scene.moving_objects import MovingObject
from tests.sim.flat_background import LENS

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]

BACKGROUND_M, MOVER_M = 10.0, 4.0
PROJECTION = Projection(LENS.focal_px, LENS.width / 2, LENS.height / 2)


def at_once(
    render: Callable[[MovingObject, int], Keyframe],
) -> Callable[[MovingObject, int], Future[Keyframe]]:
    """Return a function that renders a keyframe when it is requested."""

    def request(obj: MovingObject, t_us: int) -> Future[Keyframe]:
        done: Future[Keyframe] = Future()
        done.set_result(render(obj, t_us))
        return done

    return request


def subpixel_grid(supersample: int) -> tuple[F64, F64]:
    """Return x and y of the sub-pixels [px]."""
    y, x = (np.mgrid[: LENS.height * supersample, : LENS.width * supersample] + 0.5) / supersample
    return x, y


def surfaces_between(
    images: list[F64],
    labels: list[I32],
    supersample: int,
    now: F64,
    views: tuple[F64, F64],
    late: float,
) -> Surfaces:
    """Return the surfaces of body 1 at a time between two keyframes.

    Args:
        images: luminance of the sub-pixels at both keyframes [cd/m²].
        labels: labels of the sub-pixels at both keyframes.
        supersample: sub-pixels per pixel and axis.
        now: (3, 4) view of the body at the time.
        views: views of the body at both keyframes.
        late: the time, from 0 (first keyframe) to 1 (second keyframe).
    """
    none = np.empty(0, np.int64)
    body = MovingObject("body", "box", 1, np.array([1]), none, np.zeros((2, 3)), none)

    def render(_: MovingObject, t_us: int) -> Keyframe:
        k = t_us // 1000
        patches = cut_patches(
            images[k].astype(np.float32)[None],
            labels[k],
            {1: views[k]},
            (0, 0),
            supersample,
            LENS_BLUR_PX,
            per_pixel=supersample,
        )
        return Keyframe(t_us, patches)

    carriers = np.arange(2, dtype=np.int32)
    store = KeyframeStore(
        {"body": [0, 1000]}, (body,), at_once(render), carriers=carriers, per_pixel=supersample
    )
    t_us = round(1000 * late)
    store.advance(t_us)
    return store.surfaces(t_us, np.stack([np.eye(3, 4), now]), 1.0, PROJECTION)


def view_at(x_m: float = 0.0, y_m: float = 0.0, z_m: float = MOVER_M) -> F64:
    """Return the (3, 4) view of a body at a position in the camera's frame."""
    return np.column_stack([np.eye(3), [x_m, y_m, z_m]])


def even_surface(label: I32, luminance: float, supersample: int) -> Surfaces:
    """Return the surfaces of body 1 at rest, evenly bright."""
    image = np.where(label == 1, luminance, 7e4)
    views = view_at(), view_at()
    return surfaces_between([image, image], [label, label], supersample, view_at(), views, 0.5)


def label_of_shape(shape: str, supersample: int) -> I32:
    """Return the labels of the sub-pixels for body 1 of a named shape."""
    x, y = subpixel_grid(supersample)
    inside = {
        "left half": x < 30.5,
        "upper half": y < 20.5,
        "disc": (x - 31) ** 2 + (y - 17) ** 2 < 90,
        "stripe": np.abs(x - 30 + 0.3 * y) < 0.4,
        "whole": x < 1e9,
    }[shape]
    return np.where(inside, 1, -1).astype(np.int32)


def nearness_of(label: I32) -> F32:
    """Return the nearness of the sub-pixels: the body's where it is visible."""
    return np.where(label >= 0, 1 / MOVER_M, 1 / BACKGROUND_M).astype(np.float32)
