"""Where the vehicle is: closed forms for a crossing in front of the camera.

The path is a straight line at distance d from the camera, and s is the signed way along it from
the point of closest approach, so the bearing from the camera is atan(s/d).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from sim.errors import SceneConfigError

MAX_BEARING_RAD = math.radians(80)
"""Beyond this bearing d·tan(ωt) runs away; no lens of ours sees as far (assumed)."""


class Profile(StrEnum):
    """How the motion is controlled."""

    CONSTANT_SPEED = "constant_speed"
    CONSTANT_OMEGA = "constant_omega"


@dataclass(frozen=True)
class Trajectory:
    """A crossing that is at closest approach at time 0.

    Attributes:
        omega_rad_s: angular velocity seen from the camera at closest approach [rad/s].
        distance_m: distance of closest approach [m].
        profile: constant speed along the road, or constant angular velocity.
    """

    omega_rad_s: float
    distance_m: float
    profile: Profile = Profile.CONSTANT_SPEED

    def position_m(self, t_s: float) -> float:
        """RelativeDirection along the road [m]: s = ωd·t, or s = d·tan(ωt).

        Raises:
            SceneConfigError: with constant ω, a bearing beyond `MAX_BEARING_RAD`.
        """
        if self.profile is Profile.CONSTANT_SPEED:
            return self.omega_rad_s * self.distance_m * t_s
        return self.distance_m * math.tan(self._bearing(t_s))

    def speed_m_s(self, t_s: float) -> float:
        """ds/dt [m/s]: ωd, or ωd/cos²(ωt)."""
        if self.profile is Profile.CONSTANT_SPEED:
            return self.omega_rad_s * self.distance_m
        return self.omega_rad_s * self.distance_m / math.cos(self._bearing(t_s)) ** 2

    def angular_velocity_rad_s(self, t_s: float) -> float:
        """Rate of the bearing seen from the camera [rad/s]: v·d / (d² + s²)."""
        d = self.distance_m
        return self.speed_m_s(t_s) * d / (d**2 + self.position_m(t_s) ** 2)

    def time_at_s(self, position_m: float) -> float:
        """When the vehicle is at `position_m` [s]; the inverse of `position_m`."""
        if self.profile is Profile.CONSTANT_SPEED:
            return position_m / (self.omega_rad_s * self.distance_m)
        return math.atan(position_m / self.distance_m) / self.omega_rad_s

    def _bearing(self, t_s: float) -> float:
        bearing = self.omega_rad_s * t_s
        if abs(bearing) > MAX_BEARING_RAD:
            raise SceneConfigError(
                f"at t = {t_s:.3f} s the bearing ωt is {math.degrees(bearing):.0f}°; allowed is "
                f"±{math.degrees(MAX_BEARING_RAD):.0f}°; shorten lead_s, or use constant_speed"
            )
        return bearing
