"""What lights the scene, in photometric units: sun and sky, street lamps, vehicle lamps.

Luminance-only: every source is white. A directional light is given in lux, a spot light in
candela, the sky in cd/m².
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np
import numpy.typing as npt

from sim.errors import SceneConfigError

SKY_SHARE = 0.25
"""Part of a clear day's horizontal illuminance that comes from the sky, not the sun (assumed)."""
SUN_ELEVATION_RAD, SUN_AZIMUTH_RAD = math.radians(48), math.radians(-30)
"""The sun stands behind the camera's left shoulder (assumed): azimuth from the optical axis."""
NIGHT_SKY_CD_M2 = 0.01
"""Zenith over a lit city; a dark site has 0.0002 (assumed)."""

LAMP_CUTOFF_DEG, LAMP_SOFTNESS = 75.0, 0.3
"""A street lamp's cone, and the outer part of it over which its light fades (assumed)."""
LAMP_RANGE_M = 60.0
"""Where Filament lets a lamp's light end: far beyond what is in view (assumed)."""
HEAD_LAMP_SOFTNESS = 0.8
"""Part of a beam over which its light fades (assumed)."""
HEAD_LAMP_CD, HEAD_LAMP_CUTOFF_DEG, HEAD_LAMP_DIP = 8_000.0, 12.0, 0.21
"""Dipped beam: candela, cone, and slope below the horizontal, steep enough that nothing above the
lamp is lit (assumed; UNECE R112 allows a passing beam no more than 44 kcd)."""
HEAD_LAMP_CD_M2, TAIL_LAMP_CD_M2, STREET_LAMP_CD_M2 = 3_000.0, 400.0, 8_000.0
"""Luminance of the lenses as seen from the side (assumed)."""
OFF_EMISSION = 1e-12
TAIL_LAMP_RGB = (1.0, 0.1, 0.05)
"""Linear colour of the tail lamps' emissive texture."""

EMISSION_CD_M2 = 0.3 / 2.604e-5
"""Luminance of a material of emission 1: Filament's multiplier over its exposure (measured)."""

SKY_TEXTURE = "sky"
WHITE = (1.0, 1.0, 1.0)
"""A light's colour scales its intensity, and MuJoCo's default is a grey of 0.7."""


def add_day(spec: mujoco.MjSpec, illuminance_lux: float) -> None:
    """Add sun and uniform sky that together give `illuminance_lux` on open level ground."""
    sun_lux = illuminance_lux * (1 - SKY_SHARE) / math.sin(SUN_ELEVATION_RAD)
    spec.worldbody.add_light(
        name="sun",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        dir=-sun_direction(),
        diffuse=WHITE,
        intensity=sun_lux,
        castshadow=True,
    )
    _add_sky(spec, illuminance_lux * SKY_SHARE / math.pi)


def add_night(
    spec: mujoco.MjSpec, illuminance_lux: float, lamps_m: npt.NDArray[np.float64]
) -> None:
    """Add street lamps that together give `illuminance_lux` on the road at the origin, and a sky.

    Args:
        spec: the scene.
        illuminance_lux: wanted [lux].
        lamps_m: (n, 3) positions [m]; each shines straight down.
    """
    sky_lux = math.pi * NIGHT_SKY_CD_M2
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
    _add_sky(spec, NIGHT_SKY_CD_M2)


def add_head_lamps(body: mujoco.MjsBody, positions_m: npt.NDArray[np.float64]) -> None:
    """Add a vehicle's dipped beams, which move with `body` and shine along its x axis."""
    for k, position in enumerate(positions_m):
        body.add_light(
            name=f"head_lamp_{k}",
            type=mujoco.mjtLightType.mjLIGHT_SPOT,
            pos=position,
            dir=[1, 0, -HEAD_LAMP_DIP],
            diffuse=WHITE,
            intensity=HEAD_LAMP_CD,
            cutoff=HEAD_LAMP_CUTOFF_DEG,
            softness=HEAD_LAMP_SOFTNESS,
            range=LAMP_RANGE_M,
            castshadow=False,
        )


def sun_direction() -> npt.NDArray[np.float64]:
    """(3,) unit vector from the ground to the sun."""
    level = math.cos(SUN_ELEVATION_RAD)
    return np.array(
        [
            level * math.sin(SUN_AZIMUTH_RAD),
            -level * math.cos(SUN_AZIMUTH_RAD),
            math.sin(SUN_ELEVATION_RAD),
        ]
    )


def unit_illuminance(lamps_m: npt.NDArray[np.float64]) -> float:
    """Horizontal illuminance at the origin of lamps of one candela each [lux]: Σ cos³θ / h².

    Raises:
        SceneConfigError: a lamp lights the origin with the rim of its cone, where light fades.
    """
    height, reach = lamps_m[:, 2], np.linalg.norm(lamps_m, axis=1)
    cosine = height / reach
    angle_deg = np.degrees(np.arccos(cosine))
    full = angle_deg <= LAMP_CUTOFF_DEG * (1 - LAMP_SOFTNESS)
    if (fading := ~full & (angle_deg < LAMP_CUTOFF_DEG)).any():
        raise SceneConfigError(
            f"a street lamp at {lamps_m[fading][0].tolist()} m lights the origin with the fading "
            f"rim of its cone; allowed is up to {LAMP_CUTOFF_DEG * (1 - LAMP_SOFTNESS):g}° from "
            f"straight down, or beyond {LAMP_CUTOFF_DEG:g}°; move the lamp"
        )
    return float(np.sum(full * cosine**3 / height**2))


def set_luminance(
    material: mujoco.MjsMaterial, luminance_cd_m2: float, glow: Sequence[float] = WHITE
) -> None:
    """Make a material glow, besides what it reflects.

    Args:
        material: whose own colour plays no part.
        luminance_cd_m2: wanted [cd/m²].
        glow: linear colour of the material's emissive texture; white where it has none.
    """
    # Where a material has an emissive texture, Filament takes an emission of 0 as none given.
    emission = luminance_cd_m2 / EMISSION_CD_M2 / relative_luminance(glow)
    material.emission = max(emission, OFF_EMISSION)


def relative_luminance(rgba: npt.ArrayLike) -> float:
    """Luminance of a linear colour relative to white (Rec. 709 primaries)."""
    return float(np.asarray(rgba)[:3] @ [0.2126, 0.7152, 0.0722])


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
