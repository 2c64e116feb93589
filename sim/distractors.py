"""Distractors: what moves or flickers besides the target. All are off by default."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from flybench.checks import Range, check_ranges, member
from sim.errors import SceneConfigError


class RelativeDirection(StrEnum):
    """Direction of a distractor compared with that of the target, or none."""

    NONE = "none"
    SAME = "same"
    OPPOSITE = "opposite"


class Pavement(StrEnum):
    """Side of the street. NEAR is that of the camera; a pedestrian there occludes the target."""

    NEAR = "near"
    FAR = "far"


class VehicleKind(StrEnum):
    """Kinds of vehicles."""

    SEDAN = "sedan"
    VAN = "van"
    MOTORCYCLE = "motorcycle"


MAINS_HZ = (0, 100, 120)
"""Flicker rates: twice the frequency of the mains (50 or 60 Hz); 0: lamps on direct current."""


@dataclass(frozen=True)
class Distractors:
    """Distractors of a crossing.

    Attributes:
        wind_grade: Beaufort number of the wind in the trees; 0 is calm.
        far_vehicle: direction of a second vehicle in the far lane.
        far_vehicle_kind: kind of the second vehicle.
        far_vehicle_speed_m_s: its speed [m/s]; 10 is 36 km/h (assumed).
        far_vehicle_lag_s: time after the target at which it passes the camera [s].
        far_vehicle_reflectance: reflectance of its paint; 0.25 is a grey (assumed).
        pedestrian: direction of a pedestrian on the pavement.
        pedestrian_pavement: side of the street on which the pedestrian walks.
        pedestrian_speed_m_s: walking speed [m/s]; 1.4 is usual (Bohannon 1997).
        pedestrian_lag_s: time after the target at which the pedestrian passes the camera [s].
        shake_rms_deg: root mean square rotation of the camera about each of its axes [deg]; 0.1
            shifts the image of a DAVIS346 behind 6 mm by 0.57 px.
        shake_corner_hz: corner frequency above which the shake falls off [Hz]; 4 is a tripod in
            gusts or a hand-held camera (assumed).
        flicker_hz: flicker rate of lamps on the mains [Hz]: 100 or 120; 0: no flicker.
        flicker_depth: (max − min) / (max + min) of their output, as IEEE 1789-2015 defines it. An
            incandescent lamp has about 0.1, a lamp that follows the current up to 1 (0.2 is
            assumed).
        seed: seed of the wind and the shake.
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
                f"flicker_hz is {self.flicker_hz!r}. Allowed is 0, 100 or 120 Hz, twice the "
                "frequency of the mains. Choose one of them."
            )

    @property
    def shakes(self) -> bool:
        """True if the camera shakes."""
        return self.shake_rms_deg > 0

    @property
    def flickers(self) -> bool:
        """True if the lamps on the mains flicker."""
        return self.flicker_hz > 0 and self.flicker_depth > 0


_MEMBERS: dict[str, Any] = {
    "far_vehicle": RelativeDirection,
    "far_vehicle_kind": VehicleKind,
    "pedestrian": RelativeDirection,
    "pedestrian_pavement": Pavement,
}

RANGES: dict[str, Range] = {
    "wind_grade": Range(0, 8, remedy="Branches break above 8."),
    "far_vehicle_speed_m_s": Range(
        0.5, 40.0, "m/s", remedy="Set far_vehicle for the other direction."
    ),
    "far_vehicle_lag_s": Range(-60.0, 60.0, "s"),
    "far_vehicle_reflectance": Range(0.04, 0.8, remedy="0.04 is black paint and 0.8 is white."),
    "pedestrian_speed_m_s": Range(0.3, 2.5, "m/s", remedy="There is no running gait."),
    "pedestrian_lag_s": Range(-60.0, 60.0, "s"),
    "shake_rms_deg": Range(0.0, 3.0, "deg"),
    "shake_corner_hz": Range(0.5, 50.0, "Hz"),
    "flicker_depth": Range(0.0, 1.0),
    "seed": Range(0, 2**32 - 1),
}
