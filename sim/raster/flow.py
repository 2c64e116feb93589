"""Dense ground truth of an image: depth and optical flow at every pixel centre.

Both are exact: they follow from the rigid motion of each body. Everything is expressed in the
camera's own frame (right, down, forward), so that the camera's motion, including shake, is part of
the flow. The sky is infinitely far away: its flow comes from camera rotation alone.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Intrinsics, Projection
from sim.geometry.rigid_transform import compose_transforms, inverse_transform
from sim.raster.visibility import VisibilityMap

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]


def depth_m(visible: VisibilityMap) -> F32:
    """Return the depth along the optical axis [m].

    Returns:
        (height, width) float32; infinite for the sky.
    """
    with np.errstate(divide="ignore"):
        return np.asarray(1 / visible.nearness, np.float32)


def flow_px_s(visible: VisibilityMap, twists: F64, lens: Intrinsics) -> F32:
    """Return the optical flow at each pixel centre.

    A point X = (x, y, z) that moves at Ẋ in the camera's frame has the flow f·(ẋ/z − x·ż/z², …).

    Args:
        visible: what the camera sees.
        twists: (bodies, 3, 4) for each body, map from a position in the camera's frame to the
            velocity there of a point that is rigidly joined to the body [1/s, m/s].
        lens: intrinsics of the camera.

    Returns:
        (height, width, 2) float32, x and y [px/s].
    """
    maps = _stretched(twists, lens)
    return np.asarray(_per_pixel(visible.body, visible.nearness, maps, _eye(lens), True))


def displacement_px(visible: VisibilityMap, transforms: F64, lens: Intrinsics) -> F32:
    """Return how far the point at each pixel centre moves in the image when its body moves.

    Args:
        visible: what the camera sees at the first time.
        transforms: (bodies, 3, 4) for each body, map from a position in the camera's frame at the
            first time to the position at the second time of a point rigidly joined to the body.
        lens: intrinsics of the camera.

    Returns:
        (height, width, 2) float32, x and y [px]. The displaced point may lie outside the image or
        be occluded. The displacement is NaN where the point ends up behind the camera.
    """
    maps = _stretched(transforms, lens)
    return np.asarray(_per_pixel(visible.body, visible.nearness, maps, _eye(lens), False))


def twists_between(before: F64, now: F64, after: F64, apart_s: float) -> F64:
    """Return the velocities of rigid bodies from their poses at three times (central differences).

    Args:
        before: (bodies, 3, 4) transform from each body's frame into the camera's, half of `apart_s`
            before the time in question.
        now: the same transforms at the time in question.
        after: the same transforms half of `apart_s` after it.
        apart_s: time from `before` to `after` [s].

    Returns:
        (bodies, 3, 4) map from a position in the camera's frame to the velocity there [1/s, m/s].
    """
    rate = (after - before) / apart_s
    back = inverse_transform(now)
    twist: F64 = rate[..., :3] @ back
    twist[..., 3] += rate[..., 3]
    return twist


def triangle_rates(corners: F64, apart_s: float) -> F64:
    """Return the velocities inside triangles that deform, from their corners at three times.

    Args:
        corners: (3, n, 3, 3) corners in the camera's frame half of `apart_s` before the time in
            question, at that time, and half of `apart_s` after it [m].
        apart_s: time from the first to the last [s].

    Returns:
        (n, 3, 4) for each triangle, the affine map from a position in its plane, in the camera's
        frame, to the velocity there [1/s, m/s].
    """
    before, now, after = corners
    rate = (after - before) / apart_s
    edges, edge_rates = now[:, 1:] - now[:, :1], rate[:, 1:] - rate[:, :1]
    normal = np.cross(edges[:, 0], edges[:, 1])
    # Rows: the two edges and the normal, along which the velocity does not change.
    frame = np.concatenate([edges, normal[:, None]], axis=1)
    change = np.concatenate([edge_rates, np.zeros_like(normal)[:, None]], axis=1)
    linear = np.swapaxes(np.linalg.solve(frame, change), -1, -2)
    shift = rate[:, 0] - (linear @ now[:, 0, :, None])[..., 0]
    return np.concatenate([linear, shift[..., None]], axis=-1)


def transforms_between(before: F64, after: F64) -> F64:
    """Return, for each body, the transform from the camera's frame at one time to another time.

    Args:
        before: (bodies, 3, 4) transform from each body's frame into the camera's at the first time.
        after: the same transforms at the second time.

    Returns:
        (bodies, 3, 4).
    """
    return compose_transforms(inverse_transform(before), after)


def _eye(lens: Intrinsics) -> Projection:
    return Projection(lens.focal_px, *lens.centre_px)


def _stretched(maps: F64, lens: Intrinsics) -> F64:
    """Return maps of the camera's frame as maps of the frame of `Intrinsics.stretched`."""
    return np.asarray(lens.stretched(maps) / np.array([1.0, lens.aspect, 1.0, 1.0]))


@compiled
def _apply(transforms: F64, k: int, x: float, y: float, near: float) -> tuple[float, float, float]:
    """Return transform `k` of the position (x, y, 1) / near, multiplied by near."""
    return (
        transforms[k, 0, 0] * x
        + transforms[k, 0, 1] * y
        + transforms[k, 0, 2]
        + transforms[k, 0, 3] * near,
        transforms[k, 1, 0] * x
        + transforms[k, 1, 1] * y
        + transforms[k, 1, 2]
        + transforms[k, 1, 3] * near,
        transforms[k, 2, 0] * x
        + transforms[k, 2, 1] * y
        + transforms[k, 2, 2]
        + transforms[k, 2, 3] * near,
    )


@compiled
def _per_pixel(
    body: I32, nearness: F32, transforms: F64, projection: Projection, rates: bool
) -> F32:
    """Apply each pixel's body motion to the point at the pixel centre.

    Args:
        body: (height, width) body numbers. The sky is negative; it rotates as the world does.
        nearness: (height, width) [1/m].
        transforms: (bodies, 3, 4) from positions to velocities, or to later positions.
        projection: projection of the camera.
        rates: True if `transforms` gives velocities.

    Returns:
        (height, width, 2) float32, x and y.
    """
    focal, centre_x, centre_y = projection
    height, width = body.shape
    out = np.empty((height, width, 2), np.float32)
    for row in range(height):
        y = (row + 0.5 - centre_y) / focal
        for column in range(width):
            x = (column + 0.5 - centre_x) / focal
            k = max(body[row, column], 0)
            a, b, c = _apply(transforms, k, x, y, nearness[row, column])
            if rates:
                out[row, column, 0] = focal * (a - x * c)
                out[row, column, 1] = focal * (b - y * c)
            else:
                out[row, column, 0] = focal * (a / c - x) if c > 0.0 else np.nan
                out[row, column, 1] = focal * (b / c - y) if c > 0.0 else np.nan
    return out
