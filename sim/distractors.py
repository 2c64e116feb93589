"""Distractors: what moves or flickers besides the target. All are off by default."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from flybench.checks import Range, check_ranges, member
from sim.errors import SceneConfigError


class RelativeDirection(StrEnum):
    """Direction of a distractor relative to the target; NONE: there is no such distractor."""

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


FLICKER_RATES_HZ = (0, 100, 120)
"""Flicker rates: twice the frequency of the mains (50 or 60 Hz); 0: lamps on direct current."""


@dataclass(frozen=True)
class Distractors:
    """Distractors of a crossing.

    Attributes:
        wind_grade: Beaufort number of the wind in the trees, 0 (calm) to 8.
        far_vehicle: Direction of a second vehicle in the far lane, relative to the target.
        far_vehicle_kind: Kind of the second vehicle.
        far_vehicle_speed_m_s: Speed of the second vehicle, 0.5 to 40 [m/s]; 10 is 36 km/h
            (assumed).
        far_vehicle_lag_s: Time after the target at which the second vehicle passes the camera, −60
            to 60 [s].
        far_vehicle_reflectance: Paint reflectance of the second vehicle, 0.04 (black) to 0.8
            (white); 0.25 is a grey (assumed).
        pedestrian: Direction of a pedestrian on the pavement, relative to the target.
        pedestrian_pavement: Side of the street on which the pedestrian walks; near is that of the
            camera.
        pedestrian_speed_m_s: Walking speed, 0.3 to 2.5 [m/s]; 1.4 is usual (Bohannon 1997).
        pedestrian_lag_s: Time after the target at which the pedestrian passes the camera, −60
            to 60 [s].
        shake_rms_deg: Root mean square rotation of the camera about each of its axes, 0
            to 3 [deg]; 0.1 deg shifts the image of a DAVIS346 with a 6 mm lens by 0.57 px.
        shake_corner_hz: Corner frequency above which the shake falls off, 0.5 to 50 [Hz]; 4 Hz is
            typical of a tripod in gusts or of a hand-held camera (assumed).
        flicker_hz: Flicker rate of lamps on the mains: 100 or 120 [Hz]; 0 for no flicker.
        flicker_depth: Depth of the flicker, 0 to 1: (max − min) / (max + min) of the output, as
            IEEE 1789-2015 defines it. An incandescent lamp has about 0.1; a lamp whose output
            follows the current has up to 1. The default of 0.2 is assumed.
        seed: Seed of the wind and the shake, 0 to 2^32 - 1.
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
        if self.flicker_hz not in FLICKER_RATES_HZ:
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
    "wind_grade": Range(0, 8, remedy="Choose a lower grade: above 8, branches break."),
    "far_vehicle_speed_m_s": Range(
        0.5, 40.0, "m/s", remedy="Set far_vehicle for the other direction."
    ),
    "far_vehicle_lag_s": Range(-60.0, 60.0, "s"),
    "far_vehicle_reflectance": Range(0.04, 0.8, remedy="0.04 is black paint and 0.8 is white."),
    "pedestrian_speed_m_s": Range(0.3, 2.5, "m/s", remedy="Choose a walking speed."),
    "pedestrian_lag_s": Range(-60.0, 60.0, "s"),
    "shake_rms_deg": Range(0.0, 3.0, "deg"),
    "shake_corner_hz": Range(0.5, 50.0, "Hz"),
    "flicker_depth": Range(0.0, 1.0),
    "seed": Range(0, 2**32 - 1),
}
