"""What a crossing is made of, checked when made."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeVar

from sim.errors import SceneConfigError
from sim.trajectory import Profile

E = TypeVar("E", bound=StrEnum)


class Lighting(StrEnum):
    """Time of day."""

    DAY = "day"
    NIGHT = "night"


class Direction(StrEnum):
    """Where the vehicle goes in the image."""

    RIGHT = "right"
    LEFT = "left"
    UP = "up"
    DOWN = "down"


DISTANCE_M = {Lighting.DAY: 6.89, Lighting.NIGHT: 7.79}
"""At these, 30, 40, 50 and 60 km/h give the paper's angular velocities, by day and by night."""

ILLUMINANCE_LUX = {Lighting.DAY: 30_000.0, Lighting.NIGHT: 10.0}
"""On the road: a clear day, and a street lit to class M4 or so (both assumed)."""


@dataclass(frozen=True)
class CrossingConfig:
    """A vehicle that crosses in front of the camera.

    Attributes:
        lighting: day or night.
        omega_rad_s: angular velocity at closest approach [rad/s]; 1.61 is the paper's 40 km/h by
            day.
        direction: in the image. Left is a vehicle that drives the other way; up and down are the
            same crossing seen by a camera rolled by a quarter turn.
        profile: constant speed, or constant angular velocity.
        distance_m: from the camera to the vehicle's near flank [m]; None: `DISTANCE_M`.
        illuminance_lux: on the road in front of the camera [lux]; None: `ILLUMINANCE_LUX`.
        lead_s: how long before the vehicle enters, and after it has left, the sequence goes on [s];
            0.15 lets a detector with a 100 ms memory settle (assumed).
        step_px: the farthest that a point may travel in the image between two samples [px].
        max_step_ms: the longest step where nothing moves [ms] (assumed).
        supersample: rendered pixels per sensor pixel, along each axis.
    """

    lighting: Lighting = Lighting.DAY
    omega_rad_s: float = 1.61
    direction: Direction = Direction.RIGHT
    profile: Profile = Profile.CONSTANT_SPEED
    distance_m: float | None = None
    illuminance_lux: float | None = None
    lead_s: float = 0.15
    step_px: float = 0.5
    max_step_ms: float = 5.0
    supersample: int = 2

    def __post_init__(self) -> None:
        for name, kind in (("lighting", Lighting), ("direction", Direction), ("profile", Profile)):
            object.__setattr__(self, name, member(kind, name, getattr(self, name)))
        if self.distance_m is None:
            object.__setattr__(self, "distance_m", DISTANCE_M[self.lighting])
        if self.illuminance_lux is None:
            object.__setattr__(self, "illuminance_lux", ILLUMINANCE_LUX[self.lighting])
        for name, (low, high, unit) in RANGES.items():
            value = getattr(self, name)
            if not (math.isfinite(value) and low <= value <= high):
                raise SceneConfigError(
                    f"{name} is {value}; allowed is {low:g} to {high:g} {unit}".rstrip()
                    + (f"; {REMEDIES[name]}" if name in REMEDIES else "")
                )

    @property
    def distance(self) -> float:
        """`distance_m`, resolved [m]."""
        assert self.distance_m is not None
        return self.distance_m

    @property
    def illuminance(self) -> float:
        """`illuminance_lux`, resolved [lux]."""
        assert self.illuminance_lux is not None
        return self.illuminance_lux


RANGES: dict[str, tuple[float, float, str]] = {
    "omega_rad_s": (0.05, 10.0, "rad/s"),
    "distance_m": (3.0, 12.0, "m"),
    "illuminance_lux": (0.1, 100_000.0, "lux"),
    "lead_s": (0.05, 10.0, "s"),
    "step_px": (0.05, 8.0, "px"),
    "max_step_ms": (0.1, 20.0, "ms"),
    "supersample": (1, 8, ""),
}

REMEDIES = {
    "omega_rad_s": "for motion the other way, give another direction",
    "distance_m": "nearer, the vehicle would drive over the camera's pavement",
}


def omega_from_speed(speed_km_h: float, distance_m: float) -> float:
    """Angular velocity at closest approach [rad/s] of a speed [km/h] at a distance [m]: v/d."""
    return speed_km_h / 3.6 / distance_m


def member(kind: type[E], name: str, value: Any) -> E:
    """The member of `kind` that `value` names.

    Raises:
        SceneConfigError: there is none.
    """
    try:
        return kind(value)
    except ValueError:
        allowed = ", ".join(kind)
        raise SceneConfigError(f"{name} is {value!r}; allowed is one of {allowed}") from None
