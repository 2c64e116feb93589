"""From a configuration to a MuJoCo model: street, vehicle, lights and camera, put together."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt

from sim import light
from sim.camera import Pose
from sim.config import CrossingConfig, Direction, Lighting

ASSETS = Path(__file__).parent / "assets"
CAMERA_HEIGHT_M = 1.2
"""Above the road, on a tripod (assumed)."""
FLANK_M = 0.9
"""From the vehicle's middle to its flank, as `sedan.xml` has it; `distance_m` is measured to it."""
WHEEL_RADIUS_M, RIM_RADIUS_M = 0.32, 0.21
"""A tyre's outer radius, and that of the spokes, as `sedan.xml` has them; the tyre itself bears no
mark that turns."""
BODY_BOX_M = np.array([[-2.35, -0.92, 0.0], [2.35, 0.92, 1.5]])
"""Corners of a box around the car of `sedan.xml`, in its own frame [m]."""
PARKED = (
    (-7.4, 6.35, 0.0, (0.05, 0.05, 0.055)),
    (5.6, 6.4, math.pi, (0.25, 0.05, 0.04)),
)
"""Parked cars: x [m], y [m], heading [rad], linear colour (assumed)."""
PREVIEW_LUX = 60_000.0
"""What the preview's eye is adapted to (by eye)."""
PREVIEW_SKY_RGB = (170, 205, 255)

_ROLL_RAD = {
    Direction.RIGHT: 0.0,
    Direction.LEFT: 0.0,
    Direction.UP: math.pi / 2,
    Direction.DOWN: -math.pi / 2,
}


@dataclass(frozen=True)
class Scene:
    """A model ready to be moved and drawn.

    Attributes:
        model: the colours as authored.
        pose: the camera's.
        vehicle_geoms: numbers of the geoms that are the target.
        heading: +1 where the vehicle drives along the world's x, -1 against it.
        config: what it was made from.
    """

    model: mujoco.MjModel
    pose: Pose
    vehicle_geoms: npt.NDArray[np.int64]
    heading: int
    config: CrossingConfig

    def place(self, data: mujoco.MjData, position_m: float) -> None:
        """Put the vehicle at a way along its path [m], its wheels turned to match."""
        data.joint("vehicle/travel").qpos[0] = position_m
        for name in ("front_right", "front_left", "rear_right", "rear_left"):
            data.joint(f"vehicle/wheel_{name}").qpos[0] = position_m / WHEEL_RADIUS_M
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_camlight(self.model, data)

    def body_corners_m(self, position_m: float) -> npt.NDArray[np.float64]:
        """(8, 3) world corners of the box around the vehicle at a way along its path."""
        corners = np.array(np.meshgrid(*BODY_BOX_M.T)).reshape(3, -1).T
        shift = np.array([position_m, 0, 0])
        return np.asarray((corners + shift) * [self.heading, 1, 1])

    def flank_m(self, position_m: float) -> npt.NDArray[np.float64]:
        """(4, 3) world corners of the near flank's rectangle at a way along its path."""
        (back, _, low), (front, _, high) = BODY_BOX_M
        ends = [(x, z) for x in (back, front) for z in (low, high)]
        return np.array([[self.heading * (x + position_m), -FLANK_M, z] for x, z in ends])

    @property
    def has_beams(self) -> bool:
        """Whether the vehicle's lamps light the road."""
        return self.config.lighting is Lighting.NIGHT

    @property
    def casters_m(self) -> list[npt.NDArray[np.float64]]:
        """Where the lights that cast shadows are: (4,) homogeneous; the last is 0 for the sun."""
        model, found = self.model, []
        for k in np.flatnonzero(model.light_castshadow):
            if model.light_type[k] == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL:
                found.append(np.append(-model.light_dir[k], 0.0))
            elif model.light_type[k] == mujoco.mjtLightType.mjLIGHT_SPOT:
                found.append(np.append(model.light_pos[k], 1.0))
        return found


def build_scene(config: CrossingConfig) -> Scene:
    """Compose the scene that `config` asks for, and compile it."""
    model = compose(config).compile()
    pose = Pose(np.array([0.0, -(config.distance + FLANK_M), CAMERA_HEIGHT_M]))
    return Scene(
        model=model,
        pose=pose.rolled(_ROLL_RAD[config.direction]),
        vehicle_geoms=_geoms_of(model, "vehicle/"),
        heading=-1 if config.direction is Direction.LEFT else 1,
        config=config,
    )


def compose(config: CrossingConfig) -> mujoco.MjSpec:
    """Street, parked cars, vehicle and lights, not yet compiled."""
    spec = _street()
    heading = -1 if config.direction is Direction.LEFT else 1
    _park(spec)
    _add_vehicle(spec, heading, lit=config.lighting is Lighting.NIGHT)
    if config.lighting is Lighting.DAY:
        light.add_day(spec, config.illuminance)
    else:
        lamps = np.array([site.pos for site in spec.sites if "street_lamp" in site.name])
        light.add_night(spec, config.illuminance, lamps)
        light.set_luminance(spec.material("lamp_lens"), light.STREET_LAMP_CD_M2)
    return spec


def preview_model(scene: Scene) -> mujoco.MjModel:
    """The scene in colour, its light scaled to what a picture for the eye is exposed for."""
    model = copy.copy(scene.model)
    gain = PREVIEW_LUX / scene.config.illuminance
    model.light_intensity[:] *= gain
    model.mat_emission[:] *= gain**0.25  # lamps in full would lose their hue
    sky = int(model.tex_adr[model.texture(light.SKY_TEXTURE).id])
    model.tex_data[sky:].reshape(-1, 3)[:] = PREVIEW_SKY_RGB
    return model


def _street() -> mujoco.MjSpec:
    return mujoco.MjSpec.from_file(str(ASSETS / "street.xml"))


def _sedan(*, lit: bool) -> mujoco.MjSpec:
    car = mujoco.MjSpec.from_file(str(ASSETS / "sedan.xml"))
    for name, luminance, glow in (
        ("head_lamp", light.HEAD_LAMP_CD_M2, light.WHITE),
        ("tail_lamp", light.TAIL_LAMP_CD_M2, light.TAIL_LAMP_RGB),
    ):
        light.set_luminance(car.material(name), luminance if lit else 0.0, glow)
    return car


def _park(spec: mujoco.MjSpec) -> None:
    for k, (x, y, heading, colour) in enumerate(PARKED):
        car = _sedan(lit=False)
        for joint in list(car.joints):
            car.delete(joint)
        car.material("paint").rgba = [*colour, 1]
        half = heading / 2
        frame = spec.worldbody.add_frame(pos=[x, y, 0], quat=[math.cos(half), 0, 0, math.sin(half)])
        spec.attach(car, prefix=f"parked_{k}/", frame=frame)


def _add_vehicle(spec: mujoco.MjSpec, heading: int, *, lit: bool) -> None:
    car = _sedan(lit=lit)
    if lit:
        lamps = np.array([site.pos for site in car.sites if "head_lamp" in site.name])
        light.add_head_lamps(car.body("sedan"), lamps)
    turn = [1, 0, 0, 0] if heading > 0 else [0, 0, 0, 1]
    frame = spec.worldbody.add_frame(pos=[0, 0, 0], quat=turn)
    spec.attach(car, prefix="vehicle/", frame=frame)


def _geoms_of(model: mujoco.MjModel, prefix: str) -> npt.NDArray[np.int64]:
    bodies = [k for k in range(model.nbody) if model.body(k).name.startswith(prefix)]
    return np.flatnonzero(np.isin(model.geom_bodyid, bodies))
