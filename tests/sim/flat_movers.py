"""Movers by hand before the level street of `tests.sim.flat`: body 1 as two keyframes show it."""

import numpy as np
import numpy.typing as npt

from sim.keyframes.store import Keyframe, KeyframeStore, cut_pieces
from sim.keyframes.surface_lookup import Surfaces
from sim.raster.aperture import LENS_BLUR_PX
from sim.scene.moving_objects import MovingObject
from tests.sim.flat import LENS

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]

STREET_M, MOVER_M = 10.0, 4.0


def grid(size: int) -> tuple[F64, F64]:
    """x and y of the fine points [px]."""
    y, x = (np.mgrid[: LENS.height * size, : LENS.width * size] + 0.5) / size
    return x, y


def surfaces(
    fine: list[F64], labels: list[I32], size: int, now: F64, views: tuple[F64, F64], late: float
) -> Surfaces:
    """Body 1 as two keyframes show it, 1000 µs apart; `views` are its poses there."""
    none = np.empty(0, np.int64)
    body = MovingObject("it", "box", 1, np.array([1]), none, np.zeros((2, 3)), none)

    def draw(_: MovingObject, t_us: int) -> Keyframe:
        k = t_us // 1000
        points = fine[k].astype(np.float32)[None]
        return Keyframe(
            t_us,
            cut_pieces(
                points, labels[k], {1: views[k]}, (0, 0), size, LENS_BLUR_PX, per_pixel=size
            ),
        )

    store = KeyframeStore(
        {"it": [0, 1000]}, (body,), draw, carriers=np.arange(2, dtype=np.int32), per_pixel=size
    )
    t_us = round(1000 * late)
    store.advance(t_us)
    return store.surfaces(t_us, np.stack([np.eye(3, 4), now]), mains=1.0)


def at(x_m: float = 0.0, y_m: float = 0.0, z_m: float = MOVER_M) -> F64:
    return np.column_stack([np.eye(3), [x_m, y_m, z_m]])


def even_mover(label: I32, luminance: float, size: int) -> Surfaces:
    """Body 1 at rest, equally bright."""
    fine = np.where(label == 1, luminance, 7e4)
    return surfaces([fine, fine], [label, label], size, at(), (at(), at()), 0.5)


def shape(kind: str, size: int) -> I32:
    x, y = grid(size)
    inside = {
        "left half": x < 30.5,
        "upper half": y < 20.5,
        "disc": (x - 31) ** 2 + (y - 17) ** 2 < 90,
        "stripe": np.abs(x - 30 + 0.3 * y) < 0.4,
        "whole": x < 1e9,
    }[kind]
    return np.where(inside, 1, -1).astype(np.int32)


def near(label: I32) -> F32:
    return np.where(label >= 0, 1 / MOVER_M, 1 / STREET_M).astype(np.float32)
