"""What a crossing is made of, checked when made."""

from __future__ import annotations

from dataclasses import asdict, dataclass
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

PAPER_OMEGA_RAD_S = {
    Lighting.DAY: (1.21, 1.61, 2.01, 2.42),
    Lighting.NIGHT: (1.07, 1.42, 1.78, 2.14),
}
"""The paper's angular velocities, Section III: 30, 40, 50 and 60 km/h."""

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
        step_px: the farthest that a point may travel in the image between two samples [px]; 0.5
            is assumed, and to be confirmed by a convergence study on this street.
        max_step_ms: the longest step where nothing moves [ms] (assumed).
        supersample: rendered pixels per sensor pixel, along each axis; 2 is
            assumed, and to be confirmed likewise.
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
        resolved = self.resolved()
        for name in RANGES:
            check_range(name, resolved[name])

    @property
    def distance(self) -> float:
        """`distance_m`, or what the lighting gives [m]."""
        return DISTANCE_M[self.lighting] if self.distance_m is None else self.distance_m

    @property
    def illuminance(self) -> float:
        """`illuminance_lux`, or what the lighting gives [lux]."""
        given = self.illuminance_lux
        return ILLUMINANCE_LUX[self.lighting] if given is None else given

    def resolved(self) -> dict[str, Any]:
        """Every field by its name, with the values that stand in for None."""
        stand_in = {"distance_m": self.distance, "illuminance_lux": self.illuminance}
        return asdict(self) | stand_in


RANGES: dict[str, tuple[float, float, str]] = {  # low, high, unit; "whole" for whole numbers
    "omega_rad_s": (0.05, 10.0, "rad/s"),
    "distance_m": (3.0, 12.0, "m"),
    "illuminance_lux": (0.1, 100_000.0, "lux"),
    "lead_s": (0.05, 10.0, "s"),
    "step_px": (0.05, 8.0, "px"),
    "max_step_ms": (0.1, 20.0, "ms"),
    "supersample": (1, 8, "whole"),
}

REMEDIES = {
    "omega_rad_s": "for motion the other way, give another direction",
    "distance_m": "nearer, the vehicle would drive over the camera's pavement",
}


def check_range(name: str, value: Any) -> None:
    """Refuse a field's value outside of `RANGES`.

    Raises:
        SceneConfigError: it is too small, too large, or no number of the kind.
    """
    low, high, unit = RANGES[name]
    kind = int if unit == "whole" else (int, float)
    if isinstance(value, kind) and not isinstance(value, bool) and low <= value <= high:
        return
    remedy = REMEDIES.get(name, "choose a value in that range")
    raise SceneConfigError(f"{name} is {value!r}; allowed is {low:g} to {high:g} {unit}; {remedy}")


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
