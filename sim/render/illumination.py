"""Illumination of any model in photometric units: a uniform sky and a sun."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.config import DEFAULT_ILLUMINANCE_LUX, Lighting
from sim.errors import SceneConfigError
from sim.scene.lighting import NIGHT_SKY_CD_M2, SKY_SHARE, sun_direction

LOWEST_SUN_DEG = 5.0
"""Least elevation of the sun, as in a crossing: a lower one gives shadows without end (assumed)."""


@dataclass(frozen=True)
class Illumination:
    """A uniform sky, and a sun or a lamp that shines from one direction.

    Attributes:
        sky_lux: illuminance from the sky on open level ground [lux]. Its luminance, `sky_lux` / π
            [cd/m²], is the same in all directions, below the horizon too.
        sun_lux: illuminance from the sun on open level ground [lux].
        sun_azimuth_deg: azimuth of the sun: 0 is the world's y, positive towards its x [deg]
            (assumed).
        sun_elevation_deg: elevation of the sun, 5 to 90 [deg] (assumed).
    """

    sky_lux: float
    sun_lux: float = 0.0
    sun_azimuth_deg: float = -150.0
    sun_elevation_deg: float = 48.0

    def __post_init__(self) -> None:
        lux = self.sky_lux, self.sun_lux
        if not (all(math.isfinite(part) and part >= 0 for part in lux) and sum(lux) > 0):
            raise SceneConfigError(
                f"sky_lux is {self.sky_lux} and sun_lux is {self.sun_lux}. Allowed are finite "
                "numbers from 0, not both 0. Choose, for example, sky_lux=500."
            )
        if not (
            LOWEST_SUN_DEG <= self.sun_elevation_deg <= 90 and math.isfinite(self.sun_azimuth_deg)
        ):
            raise SceneConfigError(
                f"the sun is at azimuth {self.sun_azimuth_deg}° and elevation "
                f"{self.sun_elevation_deg}°. Allowed are a finite azimuth and an elevation from "
                f"{LOWEST_SUN_DEG:g}° to 90°. Choose, for example, 48°."
            )

    @property
    def lux(self) -> float:
        """Illuminance on open level ground [lux]."""
        return self.sky_lux + self.sun_lux

    @property
    def to_sun(self) -> npt.NDArray[np.float64]:
        """(3,) unit vector towards the sun."""
        return sun_direction(self.sun_azimuth_deg, self.sun_elevation_deg)


_DAY_LUX = DEFAULT_ILLUMINANCE_LUX[Lighting.DAY]
_NIGHT_LUX, _NIGHT_SKY_LUX = DEFAULT_ILLUMINANCE_LUX[Lighting.NIGHT], math.pi * NIGHT_SKY_CD_M2
_INDOOR_LUX, _INDOOR_DIFFUSE = 500.0, 0.4
"""Illuminance of a task in an office (EN 12464-1: 500 lux for writing and reading), and the share
of it that walls and ceiling scatter (assumed)."""

ILLUMINATIONS = {
    "daylight": Illumination(SKY_SHARE * _DAY_LUX, (1 - SKY_SHARE) * _DAY_LUX),
    "overcast": Illumination(10_000.0),
    "dusk": Illumination(DEFAULT_ILLUMINANCE_LUX[Lighting.DUSK]),
    "indoor": Illumination(
        _INDOOR_DIFFUSE * _INDOOR_LUX, (1 - _INDOOR_DIFFUSE) * _INDOOR_LUX, sun_elevation_deg=90.0
    ),
    "night": Illumination(_NIGHT_SKY_LUX, _NIGHT_LUX - _NIGHT_SKY_LUX, sun_elevation_deg=90.0),
}
"""Illuminations by name. Day, dusk and night have the illuminance of a crossing (`sim.config`);
overcast is assumed. Indoors and at night, lamps straight above stand for the sun."""


def named_illumination(light: str | Illumination) -> Illumination:
    """Return the illumination with a name, or the given one.

    Raises:
        SceneConfigError: there is no illumination of this name.
    """
    if isinstance(light, Illumination):
        return light
    if light not in ILLUMINATIONS:
        names = ", ".join(map(repr, ILLUMINATIONS))
        raise SceneConfigError(
            f"there is no light {light!r}. Allowed are {names}, or an Illumination. Choose one of "
            "these, or None for the model's own lights."
        )
    return ILLUMINATIONS[light]
