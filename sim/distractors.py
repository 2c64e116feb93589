"""What else moves or flickers besides the target; each switchable, graded, and off by default."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from flybench.checks import Range, check_ranges, member
from sim.errors import SceneConfigError


class RelativeDirection(StrEnum):
    """Whether something is there, and which way it goes compared with the target."""

    NONE = "none"
    SAME = "same"
    OPPOSITE = "opposite"


class Pavement(StrEnum):
    """Which side of the street: the camera's, where one occludes the target, or the other."""

    NEAR = "near"
    FAR = "far"


class VehicleKind(StrEnum):
    """What drives."""

    SEDAN = "sedan"
    VAN = "van"
    MOTORCYCLE = "motorcycle"


MAINS_HZ = (0, 100, 120)
"""Twice the mains' frequency, 50 or 60 Hz; 0: lamps on direct current."""


@dataclass(frozen=True)
class Distractors:
    """What else moves or flickers.

    Attributes:
        wind_grade: Beaufort number of the wind in the trees; 0 is calm.
        far_vehicle: a second vehicle in the far lane, and which way it goes.
        far_vehicle_kind: what it is.
        far_vehicle_speed_m_s: its speed [m/s]; 10 is 36 km/h (assumed).
        far_vehicle_lag_s: how long after the target it passes the camera [s].
        far_vehicle_reflectance: of its paint; 0.25 is a grey (assumed).
        pedestrian: one who walks along the pavement, and which way.
        pedestrian_pavement: on which side.
        pedestrian_speed_m_s: walking speed [m/s]; 1.4 is usual (Bohannon 1997).
        pedestrian_lag_s: how long after the target the walker passes the camera [s].
        shake_rms_deg: root mean square of the camera's rotation about each of its axes [deg]; 0.1
            shifts a DAVIS346's image behind 6 mm by 0.57 px.
        shake_corner_hz: above it the shake's angles fall off [Hz]; 4 is a tripod in gusts or a
            hand that holds the camera (assumed).
        flicker_hz: of mains-driven lamps [Hz]: 100 or 120; 0 for none.
        flicker_depth: (max - min) / (max + min) of their light, as IEEE 1789-2015 defines it; an
            incandescent lamp has about 0.1, one whose light follows the current up to 1 (0.2 is
            assumed).
        seed: of the wind and the shake.
    """

    wind_grade: int = 0
    far_vehicle: RelativeDirection = RelativeDirection.NONE
    far_vehicle_kind: VehicleKind = VehicleKind.SEDAN
    far_vehicle_speed_m_s: float = 10.0
    far_vehicle_lag_s: float = 0.0
    far_vehicle_reflectance: float = 0.25
    pedestrian: RelativeDirection = RelativeDirection.NONE
    pedestrian_pavement: Pavement = Pavement.FAR
    pedestrian_speed_m_s: float = 1.4
    pedestrian_lag_s: float = 0.0
    shake_rms_deg: float = 0.0
    shake_corner_hz: float = 4.0
    flicker_hz: int = 0
    flicker_depth: float = 0.2
    seed: int = 0

    def __post_init__(self) -> None:
        for name, kind in _MEMBERS.items():
            object.__setattr__(
                self, name, member(kind, name, getattr(self, name), SceneConfigError)
            )
        check_ranges(self, RANGES, SceneConfigError)
        if self.flicker_hz not in MAINS_HZ:
            raise SceneConfigError(
                f"flicker_hz is {self.flicker_hz!r}; allowed is one of 0, 100 and 120 Hz, twice "
                "the mains' frequency; choose one of them"
            )

    @property
    def shakes(self) -> bool:
        """Whether the camera moves."""
        return self.shake_rms_deg > 0

    @property
    def flickers(self) -> bool:
        """Whether the lamps on the mains do."""
        return self.flicker_hz > 0 and self.flicker_depth > 0


_MEMBERS: dict[str, Any] = {
    "far_vehicle": RelativeDirection,
    "far_vehicle_kind": VehicleKind,
    "pedestrian": RelativeDirection,
    "pedestrian_pavement": Pavement,
}

RANGES: dict[str, Range] = {
    "wind_grade": Range(0, 8, remedy="Above it, branches break."),
    "far_vehicle_speed_m_s": Range(0.5, 40.0, "m/s", remedy="For the other way, set far_vehicle."),
    "far_vehicle_lag_s": Range(-60.0, 60.0, "s"),
    "far_vehicle_reflectance": Range(0.04, 0.8, remedy="Black paint to white."),
    "pedestrian_speed_m_s": Range(
        0.3, 2.5, "m/s", remedy="Faster ones run, and no gait here does."
    ),
    "pedestrian_lag_s": Range(-60.0, 60.0, "s"),
    "shake_rms_deg": Range(0.0, 3.0, "deg"),
    "shake_corner_hz": Range(0.5, 50.0, "Hz"),
    "flicker_depth": Range(0.0, 1.0),
    "seed": Range(0, 2**32 - 1),
}
