"""What moves: added to the street as the configuration asks, and found again once compiled."""

from __future__ import annotations

import mujoco

from flybench.direction import Direction
from sim.config import CrossingConfig, Lighting
from sim.distractors import Pavement, RelativeDirection, VehicleKind
from sim.motion.gait import EXCURSION_M, walking
from sim.motion.paths import Motion, Path, UniformPath, rolling
from sim.scene.assets import open_asset
from sim.scene.facades import PAVEMENT_M
from sim.scene.moving_objects import PEDESTRIAN, TREE, MovingObject, moving_object
from sim.scene.trees import Tree, sway_rng, swaying
from sim.scene.vehicles import FLANK_M, FLANK_OF_M, add_beams, add_vehicle, vehicle

NEAR_LANE_M, FAR_LANE_M = 0.0, 3.5
"""Middle of each lane, in the world's y, as `street.xml` has them."""
PAVEMENT_LANE_M = {Pavement.NEAR: -2.9, Pavement.FAR: 9.4}
"""Where pedestrians walk, likewise."""
TARGET, FAR_VEHICLE = "target", "far_vehicle"
"""Names of the vehicles as moving objects."""
TARGET_PREFIX, FAR_PREFIX, WALKER_PREFIX = "vehicle/", "far_vehicle/", "pedestrian/"


def add_movers(spec: mujoco.MjSpec, config: CrossingConfig) -> None:
    """Add all that drives or walks.

    Raises:
        SceneConfigError: a file is missing.
    """
    extra, lit = config.distractors, config.lighting is not Lighting.DAY
    forward = heading(config.direction)
    target = (config.vehicle, config.paint_reflectance, TARGET_PREFIX)
    _drive(spec, *target, lane_m=NEAR_LANE_M, heading=forward, lit=lit)
    if extra.far_vehicle is not RelativeDirection.NONE:
        far = (extra.far_vehicle_kind, extra.far_vehicle_reflectance, FAR_PREFIX)
        _drive(spec, *far, lane_m=FAR_LANE_M, heading=forward * _SIGN[extra.far_vehicle], lit=lit)
    if extra.pedestrian is not RelativeDirection.NONE:
        place = [0, PAVEMENT_LANE_M[extra.pedestrian_pavement], PAVEMENT_M]
        turn = [1, 0, 0, 0] if forward * _SIGN[extra.pedestrian] > 0 else [0, 0, 0, 1]
        frame = spec.worldbody.add_frame(pos=place, quat=turn)
        spec.attach(open_asset("pedestrian.xml"), prefix=WALKER_PREFIX, frame=frame)


def moving_things(
    model: mujoco.MjModel, config: CrossingConfig, path: Path, trees: tuple[Tree, ...]
) -> list[tuple[MovingObject, Motion]]:
    """What moves in a compiled street, and how; the target first.

    Args:
        model: with what `add_movers` adds.
        config: the same.
        path: the target's.
        trees: of the street.
    """
    extra = config.distractors
    target = _object(model, TARGET, config.vehicle, TARGET_PREFIX)
    found: list[tuple[MovingObject, Motion]] = [(target, rolling(model, TARGET_PREFIX, path))]
    if extra.far_vehicle is not RelativeDirection.NONE:
        far_path = UniformPath(extra.far_vehicle_speed_m_s, extra.far_vehicle_lag_s)
        item = _object(model, FAR_VEHICLE, extra.far_vehicle_kind, FAR_PREFIX)
        found.append((item, rolling(model, FAR_PREFIX, far_path)))
    if extra.pedestrian is not RelativeDirection.NONE:
        motion = walking(
            model,
            WALKER_PREFIX,
            speed_m_s=extra.pedestrian_speed_m_s,
            passes_s=extra.pedestrian_lag_s,
        )
        item = _object(model, PEDESTRIAN, PEDESTRIAN, WALKER_PREFIX, EXCURSION_M)
        found.append((item, motion))
    if extra.wind_grade > 0:
        rng = sway_rng(extra.seed)
        for tree in trees:
            sway, root = swaying(model, tree, extra.wind_grade, rng), int(model.body(tree.name).id)
            item = moving_object(model, tree.name, TREE, root, excursion_m=sway.excursion_m)
            found.append((item, sway))
    return found


def heading(direction: Direction) -> int:
    """+1 where a target that goes there in the image drives along the world's x, else -1."""
    return -1 if direction is Direction.LEFT else 1


def _drive(
    spec: mujoco.MjSpec,
    kind: VehicleKind,
    reflectance: float,
    prefix: str,
    *,
    lane_m: float,
    heading: int,
    lit: bool,
) -> None:
    car = vehicle(kind, reflectance, lit=lit)
    if lit:
        add_beams(car)
    add_vehicle(spec, car, prefix, lane_m=lane_m + FLANK_OF_M[kind] - FLANK_M, heading=heading)


def _object(
    model: mujoco.MjModel, name: str, kind: str, prefix: str, excursion_m: float = 0.0
) -> MovingObject:
    root = int(model.jnt_bodyid[model.joint(f"{prefix}travel").id])
    return moving_object(model, name, str(kind), root, excursion_m=excursion_m)


_SIGN = {RelativeDirection.SAME: 1, RelativeDirection.OPPOSITE: -1}
