"""Camera shake: the camera rotates about its three axes and does not translate."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import Pose
from sim.motion.band_limited_noise import BandLimitedNoise, band_limited_noise

F64 = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Shake:
    """Rotation of a camera over time.

    Attributes:
        axes: rotation about the image's right, the image's down and the optical axis over time
            [rad].
    """

    axes: tuple[BandLimitedNoise, BandLimitedNoise, BandLimitedNoise]

    def rotation_rad(self, t_s: float) -> F64:
        """Return the (3,) rotation vector in the camera's frame (right, down, forward) [rad]."""
        return np.array([axis.value(t_s) for axis in self.axes])

    def fastest_rad_s(self, t_s: float) -> float:
        """Return a bound on the angular speed of any direction: the norm of the rate [rad/s]."""
        return float(np.linalg.norm([axis.rate(t_s) for axis in self.axes]))

    def turned(self, pose: Pose, t_s: float) -> Pose:
        """Return the pose at a time [s] of a camera whose pose at rest is `pose`."""
        frame = np.stack([pose.right, -pose.up, pose.forward], axis=1)
        frame = frame @ rotation(self.rotation_rad(t_s))
        return Pose(pose.position_m, frame[:, 0], -frame[:, 1])


def camera_shake(rms_deg: float, corner_hz: float, seed: int) -> Shake:
    """Draw a shake with the same standard deviation about each of the three independent axes."""
    rng = np.random.default_rng([seed, _SHAKE_STREAM])
    first, second, third = (
        band_limited_noise(rng, rms=math.radians(rms_deg), corner_hz=corner_hz) for _ in range(3)
    )
    return Shake((first, second, third))


def rotation(vector_rad: F64) -> F64:
    """Return the (3, 3) matrix of a rotation vector, whose length is the angle (Rodrigues)."""
    angle = float(np.linalg.norm(vector_rad))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector_rad / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turned: F64 = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * (cross @ cross)
    return turned


_SHAKE_STREAM = 1
"""Random stream of the shake, distinct from that of the wind with the same seed."""
