"""The pinhole camera: intrinsics, pose and projection.

Image coordinates are continuous: x to the right and y down, in pixels, with (0, 0) at the outer
corner of the first pixel, so that pixel (i, j) covers [i, i+1) × [j, j+1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Vectors = npt.NDArray[np.float64]

NEAR_M = 0.05
"""Distance of the near clipping plane [m] (assumed)."""


@dataclass(frozen=True)
class Intrinsics:
    """Intrinsics of a lens without distortion whose axis passes through the middle of the sensor.

    The defaults are a DAVIS346 behind a 6 mm lens: 18.5 µm pixels (Taverni et al. 2018).
    """

    width: int = 346
    height: int = 260
    focal_px: float = 6.0e-3 / 18.5e-6

    def with_margin(self, margin_px: int) -> Intrinsics:
        """Return this lens with a sensor that is larger by a margin on all sides [px]."""
        return Intrinsics(self.width + 2 * margin_px, self.height + 2 * margin_px, self.focal_px)

    def scaled(self, factor: int) -> Intrinsics:
        """Return this field of view with `factor` times as many pixels along each axis."""
        return Intrinsics(self.width * factor, self.height * factor, self.focal_px * factor)

    @property
    def half_width_rad(self) -> float:
        """Half the horizontal field of view [rad]."""
        return math.atan(self.width / 2 / self.focal_px)

    @property
    def half_height_rad(self) -> float:
        """Half the vertical field of view [rad]."""
        return math.atan(self.height / 2 / self.focal_px)


@dataclass(frozen=True)
class Pose:
    """Pose of a camera in the world.

    Attributes:
        position_m: (3,) position of the optical centre [m].
        right: (3,) unit vector along image x.
        up: (3,) unit vector against image y.
    """

    position_m: Vectors
    right: Vectors = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    up: Vectors = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))

    @cached_property
    def forward(self) -> Vectors:
        """(3,) unit vector along the optical axis."""
        return np.cross(self.up, self.right)

    @cached_property
    def world_to_camera(self) -> Vectors:
        """(3, 4) rigid transform from the world to the camera's frame (right, down, forward)."""
        axes = np.stack([self.right, -self.up, self.forward])
        return np.column_stack([axes, -axes @ self.position_m])

    def rolled(self, angle_rad: float) -> Pose:
        """Return this pose rolled about the optical axis, image x towards image y [rad]."""
        cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
        right = cosine * self.right - sine * self.up
        return Pose(self.position_m, right, cosine * self.up + sine * self.right)


class Projection(NamedTuple):
    """Focal length and principal point of a camera, for kernels [px]."""

    focal: float
    centre_x: float
    centre_y: float


def project(points_m: Vectors, pose: Pose, intrinsics: Intrinsics) -> tuple[Vectors, Vectors]:
    """Project world points onto the image.

    Args:
        points_m: (n, 3) world coordinates [m].
        pose: pose of the camera.
        intrinsics: lens and sensor of the camera.

    Returns:
        (n, 2) image coordinates [px] and (n,) depths along the optical axis [m]. A point with a
        depth of 0 or less is behind the camera; its coordinates have no meaning.
    """
    relative = points_m - pose.position_m
    depth = relative @ pose.forward
    safe = np.where(depth > 0, depth, np.nan)
    x = intrinsics.width / 2 + intrinsics.focal_px * (relative @ pose.right) / safe
    y = intrinsics.height / 2 - intrinsics.focal_px * (relative @ pose.up) / safe
    return np.stack([x, y], axis=1), depth
