"""Configuration of a crossing, checked when it is made."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any

from flybench.checks import Range, check_ranges, member
from flybench.direction import Direction
from sim.distractors import Distractors, Pavement, RelativeDirection, VehicleKind
from sim.errors import SceneConfigError
from sim.motion.trajectory import Profile


class Lighting(StrEnum):
    """Time of day."""

    DAY = "day"
    DUSK = "dusk"
    NIGHT = "night"


class Quality(StrEnum):
    """How finely a crossing is rendered."""

    DRAFT = "draft"
    FULL = "full"
    FINE = "fine"


DRAFT_STEP, DRAFT_KEYFRAME = 1.6, 2.0
"""Factors of `step_px` and `keyframe_px` in a draft. `python -m tools.convergence_table` measures
what they cost."""

MAX_KEYFRAME_PX = 64.0
"""Largest distance between keyframes [px]. With 128, surfaces that no keyframe shows are black in
some samples (measured)."""

DEFAULT_DISTANCE_M = {Lighting.DAY: 6.89, Lighting.DUSK: 6.89, Lighting.NIGHT: 7.79}
"""Default distances [m]. At these, 30, 40, 50 and 60 km/h give the paper's angular velocities by
day and by night. Dusk, which is not in the paper, has the same distance as day."""

PAPER_OMEGA_RAD_S = {
    Lighting.DAY: (1.21, 1.61, 2.01, 2.42),
    Lighting.NIGHT: (1.07, 1.42, 1.78, 2.14),
}
"""The paper's angular velocities, Section III: 30, 40, 50 and 60 km/h."""

DEFAULT_ILLUMINANCE_LUX = {Lighting.DAY: 30_000.0, Lighting.DUSK: 50.0, Lighting.NIGHT: 10.0}
"""Default illuminance on the road [lux]: a clear day, about twenty minutes after sunset under a
clear sky, and a street lit to about class M4 (all assumed)."""


@dataclass(frozen=True)
class CrossingConfig:
    """Configuration of a vehicle that crosses in front of the camera.

    Attributes:
        lighting: time of day: day, dusk or night.
        omega_rad_s: angular velocity at closest approach [rad/s]; 1.61 is the paper's 40 km/h by
            day.
        direction: direction of motion in the image. For left, the vehicle drives the other way; for
            up and down, the camera is rolled by 90°.
        profile: constant speed, or constant angular velocity.
        vehicle: kind of vehicle.
        paint_reflectance: luminance reflectance of the paint, 0.04 (black) to 0.8 (white). 0.53 is
            silver (assumed). At 0.13 the vehicle has nearly no contrast to the road by day
            (measured).
        distance_m: distance from the camera to the near flank of the vehicle [m]; None:
            `DEFAULT_DISTANCE_M`.
        illuminance_lux: illuminance on the road in front of the camera [lux]; None:
            `DEFAULT_ILLUMINANCE_LUX`.
        sun_azimuth_deg: azimuth of the sun by day: 0 is straight ahead of the camera, positive to
            its right [deg]; −150 is behind its left shoulder (assumed).
        sun_elevation_deg: elevation of the sun by day, above the horizon [deg] (assumed).
        street_seed: seed of everything that is drawn at random in the street: façades, trees,
            parked cars and lit windows.
        distractors: what else moves or flickers; nothing by default.
        lead_s: time before the vehicle enters and after it has left [s]; 0.15 lets a detector with
            a memory of 100 ms settle (assumed).
        step_px: largest distance that a point may move in the image between two samples [px]; see
            `flybench converge`.
        max_step_ms: longest step when nothing moves [ms] (assumed).
        supersample: rendered sub-pixels per sensor pixel along each axis; see `flybench converge`.
        keyframe_px: distance that an object moves in the image from one keyframe to the next [px];
            see `flybench converge`.
        quality: draft, full or fine. Full quality is what `step_px` and `keyframe_px` say. In a
            draft, samples are 1.6 times and keyframes twice as far apart. In a draft and in fine
            quality, `Crossing.samples` adds a sample half way between two; see
            `sim.keyframes.midpoints`.
    """

    lighting: Lighting = Lighting.DAY
    omega_rad_s: float = 1.61
    direction: Direction = Direction.RIGHT
    profile: Profile = Profile.CONSTANT_SPEED
    vehicle: VehicleKind = VehicleKind.SEDAN
    paint_reflectance: float = 0.53
    distance_m: float | None = None
    illuminance_lux: float | None = None
    sun_azimuth_deg: float = -150.0
    sun_elevation_deg: float = 48.0
    street_seed: int = 0
    distractors: Distractors = field(default_factory=Distractors)
    lead_s: float = 0.15
    step_px: float = 0.5
    max_step_ms: float = 5.0
    supersample: int = 3
    keyframe_px: float = 32.0
    quality: Quality = Quality.FULL

    def __post_init__(self) -> None:
        for name, kind in _MEMBERS.items():
            value = member(
                kind, name, getattr(self, name), SceneConfigError, without=(Direction.NONE,)
            )
            object.__setattr__(self, name, value)
        check_ranges(self, RANGES, SceneConfigError)
        self._check_pedestrian()
        if self.drawn_keyframe_px > MAX_KEYFRAME_PX:
            raise SceneConfigError(
                f"keyframe_px is {self.keyframe_px!r} in a draft, whose keyframes are "
                f"{DRAFT_KEYFRAME:g} times as far apart. Allowed is 1 to "
                f"{MAX_KEYFRAME_PX / DRAFT_KEYFRAME:g} px in a draft. Choose a smaller distance, "
                "or full quality."
            )

    def _check_pedestrian(self) -> None:
        near = self.distractors.pedestrian_pavement is Pavement.NEAR
        walks = self.distractors.pedestrian is not RelativeDirection.NONE
        if walks and near and self.distance < MIN_DISTANCE_WITH_PEDESTRIAN_M:
            raise SceneConfigError(
                f"distance_m is {self.distance!r} and a pedestrian on the near pavement would walk "
                f"into the camera. Allowed is {MIN_DISTANCE_WITH_PEDESTRIAN_M:g} to 12 m with this "
                "pedestrian. "
                "Choose a greater distance, or the far pavement."
            )

    @property
    def distance(self) -> float:
        """`distance_m`, or the default of the time of day [m]."""
        return DEFAULT_DISTANCE_M[self.lighting] if self.distance_m is None else self.distance_m

    @property
    def illuminance(self) -> float:
        """`illuminance_lux`, or the default of the time of day [lux]."""
        given = self.illuminance_lux
        return DEFAULT_ILLUMINANCE_LUX[self.lighting] if given is None else given

    @property
    def has_midpoints(self) -> bool:
        """True if `quality` asks for samples between those that are rendered."""
        return self.quality is not Quality.FULL

    @property
    def drawn_step_px(self) -> float:
        """Largest distance that a point may move between two samples that are rendered [px]."""
        return self.step_px * (DRAFT_STEP if self.quality is Quality.DRAFT else 1.0)

    @property
    def drawn_keyframe_px(self) -> float:
        """Distance that an object moves from one rendered keyframe to the next [px]."""
        return self.keyframe_px * (DRAFT_KEYFRAME if self.quality is Quality.DRAFT else 1.0)

    def resolved(self) -> dict[str, Any]:
        """Return every field by name, with defaults in place of None."""
        stand_in = {"distance_m": self.distance, "illuminance_lux": self.illuminance}
        return asdict(self) | stand_in


MIN_DISTANCE_WITH_PEDESTRIAN_M = 4.0
"""Smallest distance to the target with a pedestrian on the near pavement [m]: it leaves more than a
metre between the pedestrian and the camera (assumed: a metre is enough)."""

_MEMBERS: dict[str, Any] = {
    "lighting": Lighting,
    "direction": Direction,
    "profile": Profile,
    "vehicle": VehicleKind,
    "quality": Quality,
}

RANGES: dict[str, Range] = {
    "omega_rad_s": Range(
        0.05, 10.0, "rad/s", remedy="Choose another direction for motion the other way."
    ),
    "paint_reflectance": Range(0.04, 0.8, remedy="Choose 0.04 (black) to 0.8 (white)."),
    "distance_m": Range(
        3.0,
        12.0,
        "m",
        optional=True,
        remedy="Keep that distance: nearer, the vehicle would drive over the pavement.",
    ),
    "illuminance_lux": Range(0.1, 100_000.0, "lux", optional=True),
    "sun_azimuth_deg": Range(-180.0, 180.0, "deg", remedy="Add or subtract 360."),
    "sun_elevation_deg": Range(5.0, 90.0, "deg", remedy="Choose dusk for a lower sun."),
    "street_seed": Range(0, 2**32 - 1),
    "lead_s": Range(0.05, 10.0, "s"),
    "step_px": Range(0.05, 8.0, "px"),
    "max_step_ms": Range(0.1, 20.0, "ms"),
    "supersample": Range(1, 8),
    "keyframe_px": Range(1.0, MAX_KEYFRAME_PX, "px"),
}


def omega_from_speed(speed_km_h: float, distance_m: float) -> float:
    """Return the angular velocity v/d at closest approach [rad/s].

    Args:
        speed_km_h: speed of the vehicle [km/h].
        distance_m: distance at closest approach [m].
    """
    return speed_km_h / 3.6 / distance_m
