"""What is really so at a sample: the ground truth that a detector is judged on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.camera import Intrinsics, project
from sim.config import Direction
from sim.renderer import Window
from sim.scene import Scene
from sim.trajectory import Trajectory

IMAGE_DIRECTION = {
    Direction.RIGHT: np.array([1.0, 0.0]),
    Direction.LEFT: np.array([-1.0, 0.0]),
    Direction.UP: np.array([0.0, -1.0]),
    Direction.DOWN: np.array([0.0, 1.0]),
}
"""(2,) unit vectors in the image, x right and y down."""


@dataclass(frozen=True)
class GroundTruth:
    """The target at one sample.

    Attributes:
        t_us: time [µs].
        direction: in the image.
        angular_velocity_rad_s: rate of the bearing of the flank's middle, seen from the camera.
        image_velocity_px_s: (2,) velocity of the flank in the image; x right, y down.
        position_m: way of the vehicle's middle from the point of closest approach [m].
        reference_px: (2,) where the flank's middle is in the image, also outside of it.
        visibility: share of the rectangle around the projected vehicle that lies inside the
            image, 0 to 1; what stands in front of it is not considered.
        mask: (height, width) bool, the pixels whose middle shows the target.
        bounding_box_px: x0, y0, x1, y1 of the mask, half-open; None where it is empty.
        centroid_px: (2,) centre of gravity of the mask; None where it is empty.
    """

    t_us: int
    direction: Direction
    angular_velocity_rad_s: float
    image_velocity_px_s: npt.NDArray[np.float64]
    position_m: float
    reference_px: npt.NDArray[np.float64]
    visibility: float
    mask: npt.NDArray[np.bool_]
    bounding_box_px: Window | None
    centroid_px: npt.NDArray[np.float64] | None

    @property
    def in_view(self) -> bool:
        """Whether any pixel shows the target."""
        return self.bounding_box_px is not None


def ground_truth(
    scene: Scene,
    trajectory: Trajectory,
    intrinsics: Intrinsics,
    *,
    t_us: int,
    t_s: float,
    mask: npt.NDArray[np.bool_],
) -> GroundTruth:
    """The truth at a time on a trajectory.

    Args:
        scene: what is seen.
        trajectory: the target's.
        intrinsics: the lens and sensor.
        t_us: time since the start of the sequence [µs].
        t_s: the same instant, since closest approach [s].
        mask: (height, width) bool, where the target is seen.
    """
    direction = scene.config.direction
    position = trajectory.position_m(t_s)
    pose = scene.pose_at(t_s)
    corners, _ = project(scene.flank_m(position), pose, intrinsics)
    body, _ = project(scene.body_corners_m(position), pose, intrinsics)
    speed_px_s = intrinsics.focal_px * trajectory.speed_m_s(t_s) / trajectory.distance_m
    return GroundTruth(
        t_us=t_us,
        direction=direction,
        angular_velocity_rad_s=trajectory.angular_velocity_rad_s(t_s),
        image_velocity_px_s=speed_px_s * IMAGE_DIRECTION[direction],
        position_m=position,
        reference_px=corners.mean(axis=0),
        visibility=visible_share(body, intrinsics),
        mask=mask,
        bounding_box_px=bounding_box(mask),
        centroid_px=centroid(mask),
    )


def visible_share(corners_px: npt.NDArray[np.float64], intrinsics: Intrinsics) -> float:
    """Share of the upright rectangle around `corners_px`, (n, 2), that lies inside the image."""
    low, high = corners_px.min(axis=0), corners_px.max(axis=0)
    inside = np.clip([low, high], 0, [intrinsics.width, intrinsics.height])
    return float(np.prod(inside[1] - inside[0]) / np.prod(high - low))


def bounding_box(mask: npt.NDArray[np.bool_]) -> Window | None:
    """Smallest half-open box x0, y0, x1, y1 around a mask [px]; None where it is empty."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    if not columns.size:
        return None
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1


def centroid(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64] | None:
    """(2,) centre of gravity of a mask, x and y [px]; None where it is empty."""
    rows, columns = np.nonzero(mask)
    if not rows.size:
        return None
    return np.array([columns.mean() + 0.5, rows.mean() + 0.5])
