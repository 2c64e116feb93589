"""Vehicles: their MJCF files, paint and lamps."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from sim.distractors import VehicleKind
from sim.scene import lighting
from sim.scene.assets import open_asset

Hue = tuple[float, float, float]

FLANK_M = 0.9
"""Distance from the middle of a lane to the near flank of any vehicle on it [m] (assumed: half the
width of the sedan). Narrower and wider vehicles are shifted sideways, so that their flank is
`distance_m` from the camera."""
FLANK_OF_M = {VehicleKind.SEDAN: 0.9, VehicleKind.VAN: 1.0, VehicleKind.MOTORCYCLE: 0.4}
"""Distance from the middle of each vehicle to its flank, as in its MJCF file [m]."""
PAINT = "paint"
"""Name of the paint material in every vehicle's MJCF file."""
HUES = {
    VehicleKind.SEDAN: (0.95, 1.0, 1.1),
    VehicleKind.VAN: (1.0, 1.0, 0.97),
    VehicleKind.MOTORCYCLE: (1.6, 0.85, 0.7),
}
"""Linear colours of the paints, before they are scaled to a luminance (by eye)."""


def vehicle(
    kind: VehicleKind, reflectance: float, *, lit: bool, hue: Hue | None = None
) -> mujoco.MjSpec:
    """Return the model of one vehicle: origin on the ground under its middle, x forward.

    Args:
        kind: kind of vehicle.
        reflectance: luminance reflectance of the paint.
        lit: True if the lamps are on.
        hue: linear colour of the paint, which is scaled; None: the default of the kind.

    Raises:
        SceneConfigError: the asset file is missing.
    """
    spec = open_asset(f"{kind}.xml")
    spec.material(PAINT).rgba = [*painted(hue or HUES[kind], reflectance), 1.0]
    _light_lenses(spec, lit=lit)
    return spec


def painted(hue: Hue, reflectance: float) -> list[float]:
    """Scale a linear colour to a luminance reflectance."""
    scale = reflectance / lighting.relative_luminance(hue)
    return [part * scale for part in hue]


def add_vehicle(
    spec: mujoco.MjSpec, car: mujoco.MjSpec, prefix: str, *, lane_m: float, heading: int
) -> None:
    """Put a moving vehicle on a lane, facing along (`heading` +1) or against (-1) the world's x."""
    turn = [1, 0, 0, 0] if heading > 0 else [0, 0, 0, 1]
    frame = spec.worldbody.add_frame(pos=[0, lane_m, 0], quat=turn)
    spec.attach(car, prefix=prefix, frame=frame)


def add_beams(car: mujoco.MjSpec) -> None:
    """Add the dipped beams of a vehicle at its sites "head_lamp…"."""
    lamps = np.array([site.pos for site in car.sites if site.name.startswith("head_lamp")])
    lighting.add_head_lamps(root_body(car), lamps)


def add_parked(
    spec: mujoco.MjSpec, car: mujoco.MjSpec, prefix: str, *, x_m: float, y_m: float, turn_rad: float
) -> None:
    """Add a parked vehicle, without joints."""
    for joint in list(car.joints):
        car.delete(joint)
    half = turn_rad / 2
    frame = spec.worldbody.add_frame(pos=[x_m, y_m, 0], quat=[math.cos(half), 0, 0, math.sin(half)])
    spec.attach(car, prefix=prefix, frame=frame)


def root_body(car: mujoco.MjSpec) -> mujoco.MjsBody:
    """Return the root body of a vehicle's model."""
    return next(body for body in car.bodies if body.name != "world")


def _light_lenses(car: mujoco.MjSpec, *, lit: bool) -> None:
    for name, luminance, glow in (
        ("head_lamp", lighting.HEAD_LAMP_CD_M2, lighting.WHITE),
        ("tail_lamp", lighting.TAIL_LAMP_CD_M2, lighting.TAIL_LAMP_RGB),
    ):
        lighting.set_luminance(car.material(name), luminance if lit else 0.0, glow)
