"""The moving objects of a scene; each is one entry of `MOVERS`.

To add a moving thing, such as a cyclist:

1. Put its MJCF file in `sim/assets`, with a slide joint "travel" along its path.
2. Write its motion in `sim/motion`: a class that implements the protocol `sim.motion.paths.Motion`.
3. Give `sim.distractors.Distractors` the fields that switch it on.
4. Add an entry to `MOVERS` that puts it into the street and finds it in the compiled model.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import mujoco

from flybench.direction import Direction
from sim.config import CrossingConfig, Lighting
from sim.distractors import Pavement, RelativeDirection, VehicleKind
from sim.motion.gait import EXCURSION_M, walking
from sim.motion.paths import Motion, Path, UniformPath, rolling
from sim.scene.assets import open_asset
from sim.scene.facades import PAVEMENT_M
from sim.scene.moving_objects import MovingObject, moving_object
from sim.scene.trees import Tree, sway_rng, swaying
from sim.scene.vehicles import FLANK_M, FLANK_OF_M, add_beams, add_vehicle, vehicle

NEAR_LANE_M, FAR_LANE_M = 0.0, 3.5
"""World y of the middle of each lane, as in `street.xml` [m]."""
PAVEMENT_LANE_M = {Pavement.NEAR: -2.9, Pavement.FAR: 9.4}
"""World y of the line on which pedestrians walk on each pavement, as in `street.xml` [m]."""
TARGET, FAR_VEHICLE = "target", "far_vehicle"
"""Names of the vehicles as moving objects."""
TARGET_PREFIX, FAR_PREFIX, PEDESTRIAN_PREFIX = "vehicle/", "far_vehicle/", "pedestrian/"
"""Prefixes of the names of everything that belongs to a moving thing in the compiled model."""

Found = Iterator[tuple[MovingObject, Motion]]


@dataclass(frozen=True)
class CompiledStreet:
    """A compiled street in which moving things are found.

    Attributes:
        model: the compiled model.
        config: configuration of the crossing.
        path: path of the target.
        trees: trees of the street.
    """

    model: mujoco.MjModel
    config: CrossingConfig
    path: Path
    trees: tuple[Tree, ...]

    def root(self, prefix: str) -> int:
        """Return the number of the body that the slide joint "travel" moves."""
        return int(self.model.jnt_bodyid[self.model.joint(f"{prefix}travel").id])


@dataclass(frozen=True)
class Mover:
    """One moving thing that a configuration may ask for.

    Attributes:
        is_wanted: returns True if a configuration contains it.
        add: adds it to a street that is not compiled yet.
        find: finds it in the compiled street, with its motion.
    """

    is_wanted: Callable[[CrossingConfig], bool]
    add: Callable[[mujoco.MjSpec, CrossingConfig], None]
    find: Callable[[CompiledStreet], Found]


def add_movers(spec: mujoco.MjSpec, config: CrossingConfig) -> None:
    """Add every moving thing that a configuration asks for.

    Raises:
        SceneConfigError: an asset file is missing.
    """
    for mover in MOVERS:
        if mover.is_wanted(config):
            mover.add(spec, config)


def find_movers(
    model: mujoco.MjModel, config: CrossingConfig, path: Path, trees: tuple[Tree, ...]
) -> list[tuple[MovingObject, Motion]]:
    """Return the moving objects of a compiled street with their motions, the target first.

    Args:
        model: compiled model, with what `add_movers` adds.
        config: configuration that `add_movers` was given.
        path: path of the target.
        trees: trees of the street.
    """
    street = CompiledStreet(model, config, path, trees)
    return [found for mover in MOVERS if mover.is_wanted(config) for found in mover.find(street)]


def heading(direction: Direction) -> int:
    """Return +1 if a target with this image direction drives along the world's x, else -1."""
    return -1 if direction is Direction.LEFT else 1


def _add_target(spec: mujoco.MjSpec, config: CrossingConfig) -> None:
    car = _vehicle(config.vehicle, config.paint_reflectance, config)
    _put_on_lane(spec, car, config.vehicle, TARGET_PREFIX, NEAR_LANE_M, heading(config.direction))


def _find_target(street: CompiledStreet) -> Found:
    item = moving_object(
        street.model,
        TARGET,
        str(street.config.vehicle),
        street.root(TARGET_PREFIX),
    )
    yield item, rolling(street.model, TARGET_PREFIX, street.path)


def _add_far_vehicle(spec: mujoco.MjSpec, config: CrossingConfig) -> None:
    extra = config.distractors
    car = _vehicle(extra.far_vehicle_kind, extra.far_vehicle_reflectance, config)
    ahead = heading(config.direction) * _SIGN[extra.far_vehicle]
    _put_on_lane(spec, car, extra.far_vehicle_kind, FAR_PREFIX, FAR_LANE_M, ahead)


def _find_far_vehicle(street: CompiledStreet) -> Found:
    extra = street.config.distractors
    path = UniformPath(extra.far_vehicle_speed_m_s, extra.far_vehicle_lag_s)
    item = moving_object(
        street.model,
        FAR_VEHICLE,
        str(extra.far_vehicle_kind),
        street.root(FAR_PREFIX),
    )
    yield item, rolling(street.model, FAR_PREFIX, path)


def _add_pedestrian(spec: mujoco.MjSpec, config: CrossingConfig) -> None:
    extra = config.distractors
    ahead = heading(config.direction) * _SIGN[extra.pedestrian]
    frame = spec.worldbody.add_frame(
        pos=[0, PAVEMENT_LANE_M[extra.pedestrian_pavement], PAVEMENT_M],
        quat=[1, 0, 0, 0] if ahead > 0 else [0, 0, 0, 1],
    )
    spec.attach(open_asset("pedestrian.xml"), prefix=PEDESTRIAN_PREFIX, frame=frame)


def _find_pedestrian(street: CompiledStreet) -> Found:
    extra = street.config.distractors
    item = moving_object(
        street.model,
        "pedestrian",
        "pedestrian",
        street.root(PEDESTRIAN_PREFIX),
        excursion_m=EXCURSION_M,
        has_limbs=True,
    )
    motion = walking(
        street.model,
        PEDESTRIAN_PREFIX,
        speed_m_s=extra.pedestrian_speed_m_s,
        passes_s=extra.pedestrian_lag_s,
    )
    yield item, motion


def _find_trees(street: CompiledStreet) -> Found:
    extra, rng = street.config.distractors, sway_rng(street.config.distractors.seed)
    for tree in street.trees:
        sway = swaying(street.model, tree, extra.wind_grade, rng)
        item = moving_object(
            street.model,
            tree.name,
            "tree",
            int(street.model.body(tree.name).id),
            excursion_m=sway.excursion_m,
            has_limbs=True,
        )
        yield item, sway


def _vehicle(kind: VehicleKind, reflectance: float, config: CrossingConfig) -> mujoco.MjSpec:
    """Return a vehicle whose lamps are on except by day."""
    lit = config.lighting is not Lighting.DAY
    car = vehicle(kind, reflectance, lit=lit)
    if lit:
        add_beams(car)
    return car


def _put_on_lane(
    spec: mujoco.MjSpec,
    car: mujoco.MjSpec,
    kind: VehicleKind,
    prefix: str,
    lane_m: float,
    heading: int,
) -> None:
    add_vehicle(spec, car, prefix, lane_m=lane_m + FLANK_OF_M[kind] - FLANK_M, heading=heading)


_SIGN = {RelativeDirection.SAME: 1, RelativeDirection.OPPOSITE: -1}

MOVERS = (
    Mover(lambda _: True, _add_target, _find_target),
    Mover(
        lambda config: config.distractors.far_vehicle is not RelativeDirection.NONE,
        _add_far_vehicle,
        _find_far_vehicle,
    ),
    Mover(
        lambda config: config.distractors.pedestrian is not RelativeDirection.NONE,
        _add_pedestrian,
        _find_pedestrian,
    ),
    Mover(  # the trees stand in the street anyway; wind makes them move
        lambda config: config.distractors.wind_grade > 0, lambda _spec, _config: None, _find_trees
    ),
)
"""All moving things, the target first. Their order is that of `Scene.objects`."""
