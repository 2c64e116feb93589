"""Rigid transforms as (…, 3, 4) matrices: a rotation and, in the last column, a translation."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined

F64 = npt.NDArray[np.float64]


@compiled
def axes_along(direction: F64) -> F64:
    """Return the (3, 3) rows right, down, forward of a frame that looks along a unit vector."""
    x, y, z = direction[0], direction[1], direction[2]
    if abs(z) < 0.9:  # right is level
        long = math.hypot(x, y)
        a, b, c = y / long, -x / long, 0.0
    else:
        long = math.hypot(y, z)
        a, b, c = 0.0, z / long, -y / long
    return np.array([[a, b, c], [y * c - z * b, z * a - x * c, x * b - y * a], [x, y, z]])


@inlined
def transform_point(moves: F64, k: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a point after transform `k` of (n, 3, 4)."""
    return (
        moves[k, 0, 0] * x + moves[k, 0, 1] * y + moves[k, 0, 2] * z + moves[k, 0, 3],
        moves[k, 1, 0] * x + moves[k, 1, 1] * y + moves[k, 1, 2] * z + moves[k, 1, 3],
        moves[k, 2, 0] * x + moves[k, 2, 1] * y + moves[k, 2, 2] * z + moves[k, 2, 3],
    )


def body_poses(data: mujoco.MjData) -> F64:
    """Return the (bodies, 3, 4) transforms from the frame of each body to the world."""
    return np.concatenate([data.xmat.reshape(-1, 3, 3), data.xpos[:, :, None]], axis=2)


def compose_transforms(before: F64, after: F64) -> F64:
    """Return the transform that applies `before`, then `after`."""
    moved: F64 = after[..., :3] @ before
    moved[..., 3] += after[..., 3]
    return moved


@inlined
def chain(before: F64, after: F64, out: F64) -> None:
    """Set `out` to the (3, 4) transform that applies `before`, then `after`."""
    for i in range(3):
        for j in range(4):
            out[i, j] = after[i, 3] if j == 3 else 0.0
            for k in range(3):
                out[i, j] += after[i, k] * before[k, j]


def inverse_transform(transforms: F64) -> F64:
    """Return the inverse transforms."""
    back = np.swapaxes(transforms[..., :3], -1, -2)
    return np.concatenate([back, -(back @ transforms[..., 3:])], axis=-1)
