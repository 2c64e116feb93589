"""Trajectory of the target in closed form.

The path is a straight line at distance d from the camera. The position s along it is signed and
starts at the point of closest approach, so the bearing from the camera is atan(s/d).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from sim.errors import SceneConfigError

MAX_BEARING_RAD = math.radians(80)
"""Largest bearing: d·tan(ωt) grows without bound towards 90°, and no lens that is used here has
such a wide view (assumed)."""


class Profile(StrEnum):
    """Quantity that is held constant."""

    CONSTANT_SPEED = "constant_speed"
    CONSTANT_OMEGA = "constant_omega"


@dataclass(frozen=True)
class Trajectory:
    """Trajectory of a crossing whose closest approach is at time 0.

    Attributes:
        omega_rad_s: angular velocity seen from the camera at closest approach [rad/s].
        distance_m: distance at closest approach [m].
        profile: constant speed along the road, or constant angular velocity.
    """

    omega_rad_s: float
    distance_m: float
    profile: Profile = Profile.CONSTANT_SPEED

    def position_m(self, t_s: float) -> float:
        """Return the position along the road [m]: s = ωd·t, or s = d·tan(ωt).

        Raises:
            SceneConfigError: ω is constant and the bearing exceeds `MAX_BEARING_RAD`.
        """
        if self.profile is Profile.CONSTANT_SPEED:
            return self.omega_rad_s * self.distance_m * t_s
        return self.distance_m * math.tan(self._bearing(t_s))

    def speed_m_s(self, t_s: float) -> float:
        """Return the speed ds/dt [m/s]: ωd, or ωd/cos²(ωt)."""
        if self.profile is Profile.CONSTANT_SPEED:
            return self.omega_rad_s * self.distance_m
        return self.omega_rad_s * self.distance_m / math.cos(self._bearing(t_s)) ** 2

    def angular_velocity_rad_s(self, t_s: float) -> float:
        """Return the rate of the bearing seen from the camera [rad/s]: v·d / (d² + s²)."""
        d = self.distance_m
        return self.speed_m_s(t_s) * d / (d**2 + self.position_m(t_s) ** 2)

    def time_at_s(self, position_m: float) -> float:
        """Return the time at which the target is at a position [s]; the inverse of `position_m`."""
        if self.profile is Profile.CONSTANT_SPEED:
            return position_m / (self.omega_rad_s * self.distance_m)
        return math.atan(position_m / self.distance_m) / self.omega_rad_s

    def _bearing(self, t_s: float) -> float:
        bearing = self.omega_rad_s * t_s
        if abs(bearing) > MAX_BEARING_RAD:
            raise SceneConfigError(
                f"At t = {t_s:.3f} s the bearing ωt is {math.degrees(bearing):.0f}°. "
                f"Allowed is up to ±{math.degrees(MAX_BEARING_RAD):.0f}°. "
                "Shorten lead_s, or use constant_speed."
            )
        return bearing
