"""The street: ground from `street.xml`; houses, trees, parked cars and furniture from a seed.

Sizes and positions are in metres, and assumed unless a source is given.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from sim.distractors import VehicleKind
from sim.scene.assets import open_asset
from sim.scene.facades import PAVEMENT_M, FacadeBuilder
from sim.scene.trees import Tree, add_tree
from sim.scene.vehicles import add_parked, vehicle

LAMP_X_M, LAMP_CLEARANCE_M = 2.6, 1.0
"""Position of the far street lamp along the road, as in `street.xml`, and the distance that
other things keep from it (assumed)."""
PARKING_M, PARKED_END_M = 6.35, 10.5
"""World y of the middle of the parking lane, and the farthest position of a parked car along it.
Cars beyond would be out of view and cost time (assumed)."""
CAR_M = {VehicleKind.SEDAN: 4.6, VehicleKind.VAN: 5.1}
"""Length of each vehicle, as in its MJCF file."""
GAP_M = (0.8, 5.5)
"""Smallest and largest gap between parked cars (assumed)."""
CAR_HUES = ((1.0, 1.0, 1.05), (2.2, 0.7, 0.5), (0.6, 0.9, 1.8), (0.8, 1.1, 0.8), (1.3, 1.0, 0.6))
"""Linear colours of parked cars, before they are scaled to a luminance (by eye)."""
KERB_TREES_M, TREES_END_M, TREE_GAP_M = 8.35, 11.0, (4.0, 7.5)
"""World y of the row of trees, the farthest tree along the road, and the smallest and largest
distance between trees (assumed)."""
_STREAM = 3
"""First of three random streams, distinct from those of shake and wind with the same seed."""


def build_street(seed: int, *, dark: bool, windy: bool) -> tuple[mujoco.MjSpec, tuple[Tree, ...]]:
    """Build the street without moving vehicles, pedestrians and lights.

    Args:
        seed: seed of everything that is drawn at random.
        dark: True if windows are lit.
        windy: True if the trees have joints.

    Returns:
        The model and its trees.

    Raises:
        SceneConfigError: an asset file is missing.
    """
    spec = open_asset("street.xml")
    FacadeBuilder(spec, seed, lit=dark).build()
    trees = plan_trees(np.random.default_rng([seed, _STREAM]))
    for tree in trees:
        add_tree(spec, tree, sways=windy)
    _park(spec, np.random.default_rng([seed, _STREAM + 1]))
    _furnish(spec, np.random.default_rng([seed, _STREAM + 2]))
    return spec, trees


def plan_trees(rng: np.random.Generator) -> tuple[Tree, ...]:
    """Draw the positions and sizes of the trees."""
    trees: list[Tree] = []
    x = -TREES_END_M + float(rng.uniform(0, 4))
    while x < TREES_END_M:
        if abs(x - LAMP_X_M) < LAMP_CLEARANCE_M:
            x = LAMP_X_M + LAMP_CLEARANCE_M
        trees.append(
            Tree(
                name=f"tree_{len(trees)}",
                x_m=x,
                y_m=KERB_TREES_M + float(rng.uniform(-0.1, 0.1)),
                trunk_m=float(rng.uniform(2.3, 2.9)),
                crown_m=float(rng.uniform(1.2, 1.7)),
                height_m=float(rng.uniform(2.4, 3.2)),
                seed=int(rng.integers(2**31)),
            )
        )
        x += float(rng.uniform(*TREE_GAP_M))
    return tuple(trees)


def _park(spec: mujoco.MjSpec, rng: np.random.Generator) -> None:
    """Park cars of various colours, some of them vans, along the far kerb."""
    back, number = -PARKED_END_M + float(rng.uniform(*GAP_M)) - 2.0, 0
    while back < PARKED_END_M - 3.0:
        kind = VehicleKind.VAN if rng.uniform() < 0.2 else VehicleKind.SEDAN
        reflectance = float(np.exp(rng.uniform(math.log(0.04), math.log(0.6))))
        hue = CAR_HUES[int(rng.integers(len(CAR_HUES)))]
        car = vehicle(kind, reflectance, lit=False, hue=hue)
        turn = (0.0 if rng.uniform() < 0.5 else math.pi) + float(rng.normal(0, 0.012))
        add_parked(
            spec,
            car,
            f"parked_{number}/",
            x_m=back + CAR_M[kind] / 2,
            y_m=PARKING_M + float(rng.normal(0, 0.05)),
            turn_rad=turn,
        )
        back, number = back + CAR_M[kind] + float(rng.uniform(*GAP_M)), number + 1


def _furnish(spec: mujoco.MjSpec, rng: np.random.Generator) -> None:
    """Add bins, bollards and signs on the far pavement; covers and patches in the road."""
    for x in _places(rng, 2):
        _cylinder(spec, 0.25, 0.45, (x, 8.2), PAVEMENT_M + 0.45, "iron")
    first, pitch = float(rng.uniform(-4, 0)), float(rng.uniform(1.3, 1.8))
    for k in range(int(rng.integers(3, 6))):
        _cylinder(spec, 0.06, 0.45, (first + k * pitch, 7.85), PAVEMENT_M + 0.45, "iron")
    for x in _places(rng, 2):
        _sign(spec, x, rng)
    for k in range(7):
        x, y = float(rng.uniform(-12, 12)), float(rng.uniform(-1.2, 4.6))
        top = 0.0006 + 0.0003 * k
        if k < 3:
            _cylinder(spec, 0.31, top, (x, y), top, "iron", flat=True)
            continue
        size = [float(rng.uniform(0.3, 1.6)), float(rng.uniform(0.25, 0.6)), top]
        _box(spec, size, [x, y, top], str(rng.choice(["patch_dark", "patch_light"])))


def _sign(spec: mujoco.MjSpec, x: float, rng: np.random.Generator) -> None:
    """Add a round or square road sign on a pole."""
    height = float(rng.uniform(2.3, 2.7))
    _cylinder(spec, 0.03, height / 2, (x, 7.9), PAVEMENT_M + height / 2, "iron")
    z = PAVEMENT_M + height - 0.25
    if rng.uniform() < 0.5:
        _box(spec, [0.28, 0.015, 0.28], [x, 7.855, z], "sign_blue")
        _box(spec, [0.16, 0.016, 0.2], [x, 7.852, z], "white_paint")
        return
    for radius, y, material in ((0.3, 7.855, "sign_red"), (0.22, 7.85, "white_paint")):
        disc = spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[radius, 0.015, 0],
            pos=[x, y, z],
            material=material,
            castshadow=False,
        )
        disc.quat = [math.sqrt(0.5), math.sqrt(0.5), 0, 0]


def _places(rng: np.random.Generator, count: int) -> list[float]:
    """Draw positions along the pavement that keep clear of the lamp post."""
    drawn = rng.uniform(-10, 10, count)
    near = np.abs(drawn - LAMP_X_M) < LAMP_CLEARANCE_M
    return [float(x) for x in np.where(near, drawn - 2 * LAMP_CLEARANCE_M, drawn)]


def _cylinder(
    spec: mujoco.MjSpec,
    radius: float,
    half_height: float,
    place: tuple[float, float],
    z: float,
    material: str,
    *,
    flat: bool = False,
) -> None:
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius, half_height, 0],
        pos=[*place, z],
        material=material,
        castshadow=not flat,
    )


def _box(spec: mujoco.MjSpec, size: list[float], place: list[float], material: str) -> None:
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=size,
        pos=place,
        material=material,
        castshadow=False,
    )
