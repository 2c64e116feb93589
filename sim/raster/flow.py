"""Dense truth of an image: depth and optical flow of every pixel's middle, from rigid motions.

All is said in the camera's own frame, right, down and forward, so that what the camera itself
does, its shake included, is part of the motion. The sky is infinitely far: it moves as the camera
turns, and no other way.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Intrinsics
from sim.geometry.rigid_transform import compose_transforms, inverse_transform
from sim.raster.visibility import Visible

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]


def depth_m(visible: Visible) -> F32:
    """(height, width) float32 depth along the optical axis [m]; infinite for the sky."""
    with np.errstate(divide="ignore"):
        return np.asarray(1 / visible.nearness, np.float32)


def flow_px_s(visible: Visible, twists: F64, lens: Intrinsics) -> F32:
    """Velocity in the image of what each pixel's middle shows.

    Of a point X = (x, y, z) that moves at Ẋ before the camera it is f·(ẋ/z − x·ż/z², …).

    Args:
        visible: what the camera sees.
        twists: (bodies, 3, 4) from a place in the camera's frame to the velocity there of what is
            rigidly joined to each body [1/s, m/s].
        lens: the camera's.

    Returns:
        (height, width, 2) float32, x and y [px/s].
    """
    return np.asarray(_over_image(visible.body, visible.nearness, twists, *_eye(lens), True))


def displacement_px(visible: Visible, moves: F64, lens: Intrinsics) -> F32:
    """How far what each pixel's middle shows has gone in the image when its body has moved.

    Args:
        visible: what the camera sees before.
        moves: (bodies, 3, 4) from a place in the camera's frame to where it is in the camera's
            frame later, for what is rigidly joined to each body.
        lens: the camera's.

    Returns:
        (height, width, 2) float32, x and y [px]; it may lead out of the image, or to where
        something else is in front; not a number where it leads behind the camera.
    """
    return np.asarray(_over_image(visible.body, visible.nearness, moves, *_eye(lens), False))


def twists_between(before: F64, now: F64, after: F64, apart_s: float) -> F64:
    """Velocities of rigid bodies from where they are at three times, by central differences.

    Args:
        before: (bodies, 3, 4) from each body's frame into the camera's, half of `apart_s` earlier.
        now: likewise.
        after: likewise, as much later.
        apart_s: from `before` to `after` [s].

    Returns:
        (bodies, 3, 4) from a place in the camera's frame to the velocity there [1/s, m/s].
    """
    rate = (after - before) / apart_s
    back = inverse_transform(now)
    twist: F64 = rate[..., :3] @ back
    twist[..., 3] += rate[..., 3]
    return twist


def transforms_between(before: F64, after: F64) -> F64:
    """(bodies, 3, 4) from the camera's frame at one time to its frame at another.

    Args:
        before: (bodies, 3, 4) from each body's frame into the camera's, at the first time.
        after: likewise, at the second.
    """
    return compose_transforms(inverse_transform(before), after)


def _eye(lens: Intrinsics) -> tuple[float, float, float]:
    return lens.focal_px, lens.width / 2, lens.height / 2


@compiled
def _applied(moves: F64, k: int, x: float, y: float, near: float) -> tuple[float, float, float]:
    """Matrix `k` applied to the place (x, y, 1) / near, times near."""
    return (
        moves[k, 0, 0] * x + moves[k, 0, 1] * y + moves[k, 0, 2] + moves[k, 0, 3] * near,
        moves[k, 1, 0] * x + moves[k, 1, 1] * y + moves[k, 1, 2] + moves[k, 1, 3] * near,
        moves[k, 2, 0] * x + moves[k, 2, 1] * y + moves[k, 2, 2] + moves[k, 2, 3] * near,
    )


@compiled
def _over_image(
    body: I32,
    nearness: F32,
    moves: F64,
    focal: float,
    centre_x: float,
    centre_y: float,
    rates: bool,
) -> F32:
    """What each pixel's body does to it: (height, width, 2), x and y.

    Args:
        body: (height, width), the sky below 0: it turns as the world does.
        nearness: (height, width) [1/m].
        moves: (bodies, 3, 4) from places to velocities, or to where they go.
        focal: of the camera [px].
        centre_x: where its axis meets the image [px].
        centre_y: likewise.
        rates: whether `moves` gives velocities.
    """
    height, width = body.shape
    out = np.empty((height, width, 2), np.float32)
    for row in range(height):
        y = (row + 0.5 - centre_y) / focal
        for column in range(width):
            x = (column + 0.5 - centre_x) / focal
            k = max(body[row, column], 0)
            a, b, c = _applied(moves, k, x, y, nearness[row, column])
            if rates:
                out[row, column, 0] = focal * (a - x * c)
                out[row, column, 1] = focal * (b - y * c)
            else:
                out[row, column, 0] = focal * (a / c - x) if c > 0.0 else np.nan
                out[row, column, 1] = focal * (b / c - y) if c > 0.0 else np.nan
    return out
