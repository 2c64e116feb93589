"""The pinhole camera: intrinsics, pose and projection.

Image coordinates are continuous: x to the right and y down, in pixels, with (0, 0) at the outer
corner of the first pixel, so that pixel (i, j) covers [i, i+1) × [j, j+1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sim.errors import SceneConfigError

Vectors = npt.NDArray[np.float64]

NEAR_M = 0.05
"""Distance of the near clipping plane [m] (assumed)."""


@dataclass(frozen=True)
class Intrinsics:
    """Intrinsics of a lens without distortion.

    The defaults are a DAVIS346 behind a 6 mm lens: 18.5 µm pixels (Taverni et al. 2018).

    Attributes:
        width: width of the image [px].
        height: height of the image [px].
        focal_px: focal length across the image, in widths of a pixel.
        aspect: focal length down the image, in heights of a pixel, relative to `focal_px`; 1 for
            square pixels.
        axis_px: where the optical axis meets the image, right and down from its middle [px].
    """

    width: int = 346
    height: int = 260
    focal_px: float = 6.0e-3 / 18.5e-6
    aspect: float = 1.0
    axis_px: tuple[float, float] = (0.0, 0.0)

    def with_margin(self, margin_px: int) -> Intrinsics:
        """Return this lens with a sensor that is larger by a margin on all sides [px]."""
        width, height = self.width + 2 * margin_px, self.height + 2 * margin_px
        return replace(self, width=width, height=height)

    def scaled(self, factor: int) -> Intrinsics:
        """Return this field of view with `factor` times as many pixels along each axis."""
        return Intrinsics(
            self.width * factor,
            self.height * factor,
            self.focal_px * factor,
            self.aspect,
            (self.axis_px[0] * factor, self.axis_px[1] * factor),
        )

    @property
    def centre_px(self) -> tuple[float, float]:
        """Image coordinates of the point where the optical axis meets the image [px]."""
        return self.width / 2 + self.axis_px[0], self.height / 2 + self.axis_px[1]

    def require_symmetry(self) -> None:
        """Check that pixels are square and the optical axis meets the middle of the image.

        Raises:
            SceneConfigError: one of them is not so.
        """
        if self.aspect != 1.0 or self.axis_px != (0.0, 0.0):
            raise SceneConfigError(
                f"the lens has the aspect {self.aspect:g}, and its axis is {self.axis_px} px from "
                "the middle of the image. Allowed in a crossing are 1 and (0, 0). Leave both out."
            )

    @property
    def half_width_rad(self) -> float:
        """Half the horizontal field of view [rad]."""
        left, focal_px = self.centre_px[0], self.focal_px
        return (math.atan(left / focal_px) + math.atan((self.width - left) / focal_px)) / 2

    @property
    def half_height_rad(self) -> float:
        """Half the vertical field of view [rad]."""
        above, focal_px = self.centre_px[1], self.focal_px * self.aspect
        return (math.atan(above / focal_px) + math.atan((self.height - above) / focal_px)) / 2

    def stretched(self, transforms: Vectors) -> Vectors:
        """Return transforms into the camera's frame with y multiplied by `aspect`.

        In that frame, `focal_px` is the focal length along both axes.

        Args:
            transforms: (…, 3, 4) transforms into the camera's frame (right, down, forward).
        """
        return np.asarray(transforms * np.array([1.0, self.aspect, 1.0])[:, None])


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
    centre_x, centre_y = intrinsics.centre_px
    x = centre_x + intrinsics.focal_px * (relative @ pose.right) / safe
    y = centre_y - intrinsics.focal_px * intrinsics.aspect * (relative @ pose.up) / safe
    return np.stack([x, y], axis=1), depth
