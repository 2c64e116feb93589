"""The lights of the scene in photometric units: sun and sky, street lamps, vehicle lamps.

Only luminance matters, so every source is white. A directional light is given in lux, a spot light
in candela, the sky in cd/m².
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.config import CrossingConfig, Lighting
from sim.errors import SceneConfigError

SKY_SHARE = 0.25
"""Share of the horizontal illuminance of a clear day that comes from the sky (assumed)."""
NIGHT_SKY_CD_M2 = 0.01
"""Luminance of the zenith over a lit city [cd/m²] (assumed); a dark site has 0.0002."""

LAMP_CUTOFF_DEG, LAMP_SOFTNESS = 75.0, 0.3
"""Half angle of a street lamp's cone, and the outer share of it over which the light fades
(assumed)."""
LAMP_RANGE_M = 60.0
"""Distance at which Filament cuts off the light of a lamp, far out of view [m] (assumed)."""
BEAM_SOFTNESS = 0.8
"""Share of a beam, from its rim inwards, over which the light fades (assumed)."""
BEAM_CENTRE_CD, BEAM_CENTRE_CUTOFF_DEG, BEAM_CENTRE_DIP = 10_000.0, 5.0, math.tan(math.radians(5.5))
"""Centre of a dipped beam, one per lamp: intensity, half angle of the cone, and slope below the
horizontal, so steep that nothing above the lamp is lit (assumed; UNECE R112 allows a passing beam
at most 44 kcd)."""
BEAM_WIDE_CD, BEAM_WIDE_CUTOFF_DEG, BEAM_WIDE_DIP = 1_700.0, 16.0, math.tan(math.radians(16.5))
"""Wide part of a dipped beam, per lamp: intensity, half angle and slope. The wide parts of all
lamps of a vehicle shine from the middle between them (assumed)."""
HEAD_LAMP_CD_M2, TAIL_LAMP_CD_M2, STREET_LAMP_CD_M2 = 3_000.0, 400.0, 8_000.0
"""Luminance of the lenses seen from the side (assumed)."""
OFF_EMISSION = 1e-12
"""Emission of materials that do not glow. The renderer reads 0 as "no emission given" (assumed: far
below that of anything that glows)."""
TAIL_LAMP_RGB = (1.0, 0.1, 0.05)
"""Linear colour of the emissive texture of tail lamps (by eye)."""

EMISSION_CD_M2 = 0.3 / 2.604e-5
"""Luminance of a material with emission 1 [cd/m²]: Filament's factor over its exposure
(measured)."""

SKY_TEXTURE = "sky"
"""Name of the texture of the sky."""
LAMP_LENS = "mains_lamp_lens"
"""Material of the lenses of street lamps. Names of all materials on the mains begin with
"mains_"."""
DUSK_LAMPS_LUX = 10.0
"""Illuminance from the street lamps at dusk, in addition to that of the sky [lux] (assumed; the
same as at night)."""
LUMINANCE_OF_RGB = np.array([0.2126, 0.7152, 0.0722])
"""Luminance of the linear primaries (Rec. 709)."""
WHITE = (1.0, 1.0, 1.0)
"""Colour of all lights: it scales their intensity, and MuJoCo's default is a grey of 0.7."""


@dataclass(frozen=True)
class Flicker:
    """Flicker of lamps on alternating current: a sinusoid about the mean.

    Attributes:
        rate_hz: twice the frequency of the mains [Hz].
        depth: (max − min) / (max + min).
    """

    rate_hz: float
    depth: float

    def factor(self, t_s: float) -> float:
        """Return the luminous flux at a time [s], relative to its mean."""
        return 1.0 + self.depth * math.cos(2 * math.pi * self.rate_hz * t_s)


def add_lights(spec: mujoco.MjSpec, config: CrossingConfig) -> None:
    """Add the lights of the street, so that the road gets the configured illuminance.

    By day these are sun and sky, at night the street lamps, and at dusk the sky and the street
    lamps, which give at most half of the illuminance.
    """
    lux = config.illuminance
    if config.lighting is Lighting.DAY:
        add_day(spec, lux, sun_direction(config.sun_azimuth_deg, config.sun_elevation_deg))
        return
    lamps = np.array([site.pos for site in spec.sites if site.name.startswith("street_lamp")])
    if config.lighting is Lighting.DUSK:
        sky_cd_m2 = max(lux - DUSK_LAMPS_LUX, lux / 2) / math.pi
    else:
        sky_cd_m2 = NIGHT_SKY_CD_M2
    add_night(spec, lux, lamps, sky_cd_m2)
    set_luminance(spec.material(LAMP_LENS), STREET_LAMP_CD_M2)


def add_day(spec: mujoco.MjSpec, illuminance_lux: float, to_sun: npt.NDArray[np.float64]) -> None:
    """Add sun and uniform sky that together give `illuminance_lux` on open level ground.

    Args:
        spec: model of the scene.
        illuminance_lux: illuminance [lux].
        to_sun: (3,) unit vector from the ground to the sun.
    """
    sun_lux = illuminance_lux * (1 - SKY_SHARE) / float(to_sun[2])
    spec.worldbody.add_light(
        name="sun",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        dir=-to_sun,
        diffuse=WHITE,
        intensity=sun_lux,
        castshadow=True,
    )
    _add_sky(spec, illuminance_lux * SKY_SHARE / math.pi)


def add_night(
    spec: mujoco.MjSpec,
    illuminance_lux: float,
    lamps_m: npt.NDArray[np.float64],
    sky_cd_m2: float = NIGHT_SKY_CD_M2,
) -> None:
    """Add street lamps that together give `illuminance_lux` on the road at the origin, and a sky.

    Args:
        spec: model of the scene.
        illuminance_lux: illuminance [lux].
        lamps_m: (n, 3) positions of the lamps, which shine straight down [m].
        sky_cd_m2: luminance of the sky [cd/m²].
    """
    sky_lux = math.pi * sky_cd_m2
    candela = max(illuminance_lux - sky_lux, 0.0) / unit_illuminance(lamps_m)
    for k, position in enumerate(lamps_m):
        spec.worldbody.add_light(
            name=f"street_lamp_{k}",
            type=mujoco.mjtLightType.mjLIGHT_SPOT,
            pos=position,
            dir=[0, 0, -1],
            diffuse=WHITE,
            intensity=candela,
            cutoff=LAMP_CUTOFF_DEG,
            softness=LAMP_SOFTNESS,
            range=LAMP_RANGE_M,
            castshadow=True,
        )
    _add_sky(spec, sky_cd_m2)


def add_head_lamps(body: mujoco.MjsBody, positions_m: npt.NDArray[np.float64]) -> None:
    """Add a vehicle's dipped beams, which move with `body` and shine along its x axis.

    Args:
        body: root body of the vehicle.
        positions_m: (n, 3) positions of its headlamps in the frame of the body [m].
    """
    for k, position in enumerate(positions_m):
        _add_beam(
            body,
            f"head_lamp_{k}",
            position,
            BEAM_CENTRE_CD,
            BEAM_CENTRE_CUTOFF_DEG,
            BEAM_CENTRE_DIP,
        )
    spread_cd = BEAM_WIDE_CD * len(positions_m)
    middle = positions_m.mean(axis=0)
    _add_beam(body, "head_lamp_spread", middle, spread_cd, BEAM_WIDE_CUTOFF_DEG, BEAM_WIDE_DIP)


def _add_beam(
    body: mujoco.MjsBody,
    name: str,
    position_m: npt.NDArray[np.float64],
    candela: float,
    cutoff_deg: float,
    dip: float,
) -> None:
    body.add_light(
        name=name,
        type=mujoco.mjtLightType.mjLIGHT_SPOT,
        pos=position_m,
        dir=[1, 0, -dip],
        diffuse=WHITE,
        intensity=candela,
        cutoff=cutoff_deg,
        softness=BEAM_SOFTNESS,
        range=LAMP_RANGE_M,
        castshadow=False,
    )


def sun_direction(azimuth_deg: float, elevation_deg: float) -> npt.NDArray[np.float64]:
    """Return the (3,) unit vector from the ground to the sun.

    Args:
        azimuth_deg: azimuth; 0 is the world's y, away from the camera, positive to the right [deg].
        elevation_deg: elevation above the horizon [deg].
    """
    azimuth, elevation = math.radians(azimuth_deg), math.radians(elevation_deg)
    level = math.cos(elevation)
    return np.array([level * math.sin(azimuth), level * math.cos(azimuth), math.sin(elevation)])


def unit_illuminance(lamps_m: npt.NDArray[np.float64]) -> float:
    """Return the horizontal illuminance at the origin, Σ cos³θ / h², of lamps of one candela [lux].

    Raises:
        SceneConfigError: a lamp lights the origin with the rim of its cone, where its light fades.
    """
    height, reach = lamps_m[:, 2], np.linalg.norm(lamps_m, axis=1)
    cosine = height / reach
    angle_deg = np.degrees(np.arccos(cosine))
    full = angle_deg <= LAMP_CUTOFF_DEG * (1 - LAMP_SOFTNESS)
    if (fading := ~full & (angle_deg < LAMP_CUTOFF_DEG)).any():
        raise SceneConfigError(
            f"A street lamp at {lamps_m[fading][0].tolist()} m lights the origin with the fading "
            f"rim of its cone. Allowed is up to {LAMP_CUTOFF_DEG * (1 - LAMP_SOFTNESS):g}° from "
            f"straight down, or beyond {LAMP_CUTOFF_DEG:g}°. Move the lamp."
        )
    return float(np.sum(full * cosine**3 / height**2))


def set_luminance(
    material: mujoco.MjsMaterial, luminance_cd_m2: float, glow: Sequence[float] = WHITE
) -> None:
    """Make a material emit luminance, in addition to what it reflects.

    Args:
        material: the material; its colour has no influence.
        luminance_cd_m2: luminance [cd/m²].
        glow: linear colour of the emissive texture; white if there is none.
    """
    # With an emissive texture, Filament reads an emission of 0 as "no emission given".
    emission = luminance_cd_m2 / EMISSION_CD_M2 / relative_luminance(glow)
    material.emission = max(emission, OFF_EMISSION)


def relative_luminance(rgba: npt.ArrayLike) -> float:
    """Return the luminance of a linear colour relative to white (Rec. 709 primaries)."""
    return float(np.asarray(rgba)[:3] @ LUMINANCE_OF_RGB)


def _add_sky(spec: mujoco.MjSpec, luminance_cd_m2: float) -> None:
    spec.add_texture(
        name=SKY_TEXTURE,
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=[1, 1, 1],
        rgb2=[1, 1, 1],
        width=32,
        height=32 * 6,
    )
    spec.worldbody.add_light(
        name="sky",
        type=mujoco.mjtLightType.mjLIGHT_IMAGE,
        texture=SKY_TEXTURE,
        diffuse=WHITE,
        intensity=luminance_cd_m2,
    )
