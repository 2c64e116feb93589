"""Moving objects of a scene: their bodies, geoms and lamps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import mujoco
import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class MovingObject:
    """A moving object made of rigid bodies on joints. Numbers index the model's arrays.

    Attributes:
        name: "target", "far_vehicle", "pedestrian", "tree_0" and so on.
        kind: "sedan", "van", "motorcycle", "pedestrian" or "tree".
        root: number of the root body.
        bodies: (n,) numbers of all its bodies, the root first.
        geoms: (m,) numbers of all their geoms.
        box_m: (2, 3) lowest and highest corner, in the frame of the root, of a box that holds the
            object for every position of its limbs, wheels and boughs [m].
        lamps: (k,) numbers of the lamps that move with it.
        has_limbs: True if parts swing or sway while the root hardly moves.
        wheels: (w,) numbers of the bodies that turn about a hinge named "wheel_…".
    """

    name: str
    kind: str
    root: int
    bodies: Numbers
    geoms: Numbers
    box_m: F64
    lamps: Numbers
    wheels: Numbers = field(default_factory=lambda: np.empty(0, np.int64))
    has_limbs: bool = False

    def corners_m(self, data: mujoco.MjData) -> F64:
        """Return the (8, 3) world corners of its box [m].

        Args:
            data: state of the model, with up-to-date kinematics.
        """
        turned = self._corners_m @ data.xmat[self.root].reshape(3, 3).T
        return np.asarray(turned + data.xpos[self.root])

    @property
    def has_wheels(self) -> bool:
        """True if parts turn about axles while the object moves."""
        return bool(self.wheels.size)

    @cached_property
    def _corners_m(self) -> F64:
        return box_corners_m(self.box_m)


def moving_object(
    model: mujoco.MjModel,
    name: str,
    kind: str,
    root: int,
    *,
    excursion_m: float = 0.0,
    has_limbs: bool = False,
) -> MovingObject:
    """Return the moving object whose root body is `root`.

    Args:
        model: model of the scene.
        name: name of the object.
        kind: kind of the object.
        root: number of its root body.
        excursion_m: distance that parts move beyond their rest positions [m].
        has_limbs: True if parts swing or sway.
    """
    bodies = descendants(model, root)
    geoms = np.flatnonzero(np.isin(model.geom_bodyid, bodies))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    spare = np.array([[-1.0], [1.0]]) * excursion_m
    return MovingObject(
        name=name,
        kind=kind,
        root=root,
        bodies=bodies,
        geoms=geoms,
        box_m=_box(model, data, root, geoms) + spare,
        lamps=np.flatnonzero(np.isin(model.light_bodyid, bodies)),
        wheels=_wheels(model, bodies),
        has_limbs=has_limbs and len(bodies) > 1,
    )


def _wheels(model: mujoco.MjModel, bodies: Numbers) -> Numbers:
    """Return those of some bodies that a hinge named "wheel_…" turns, after any prefix."""
    names = [model.joint(k).name.rpartition("/")[2] for k in range(model.njnt)]
    turned = [int(model.jnt_bodyid[k]) for k, n in enumerate(names) if n.startswith("wheel_")]
    return bodies[np.isin(bodies, turned)]


def descendants(model: mujoco.MjModel, root: int) -> Numbers:
    """Return the (n,) numbers of `root` and its descendants, which have greater numbers."""
    found = {root}
    for body in range(root + 1, model.nbody):
        if int(model.body_parentid[body]) in found:
            found.add(body)
    return np.array(sorted(found), np.int64)


def box_corners_m(box_m: F64) -> F64:
    """Return the (8, 3) corners of a box from its lowest and highest corner, (2, 3)."""
    return np.array(np.meshgrid(*box_m.T)).reshape(3, -1).T


def _box(model: mujoco.MjModel, data: mujoco.MjData, root: int, geoms: Numbers) -> F64:
    axes, origin = data.xmat[root].reshape(3, 3), data.xpos[root]
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for geom in geoms:
        turned = axes.T @ data.geom_xmat[geom].reshape(3, 3)
        below, above = _extent(model, int(geom), turned)
        middle = (data.geom_xpos[geom] - origin) @ axes
        low, high = np.minimum(low, middle + below), np.maximum(high, middle + above)
    return np.array([low, high])


def _extent(model: mujoco.MjModel, geom: int, axes: F64) -> tuple[F64, F64]:
    """Return how far a geom reaches from its centre along each axis, in both directions [m].

    The columns of `axes` are the axes of the geom.
    """
    kind = mujoco.mjtGeom(model.geom_type[geom])
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        start, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        turned = model.mesh_vert[start : start + count].astype(np.float64) @ axes.T
        return turned.min(axis=0), turned.max(axis=0)
    reach = _REACH[kind](model.geom_size[geom], axes)
    return -reach, reach


def _flat(height: F64) -> F64:
    """Return the length of a unit vector projected onto a plane, given its height above it."""
    return np.asarray(np.sqrt(np.clip(1 - height**2, 0, 1)))


_REACH: dict[mujoco.mjtGeom, Callable[[F64, F64], F64]] = {
    mujoco.mjtGeom.mjGEOM_BOX: lambda size, axes: np.abs(axes) @ size,
    mujoco.mjtGeom.mjGEOM_SPHERE: lambda size, _: np.full(3, size[0]),
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: lambda size, axes: np.linalg.norm(axes * size, axis=1),
    mujoco.mjtGeom.mjGEOM_CAPSULE: lambda size, axes: size[0] + size[1] * np.abs(axes[:, 2]),
    mujoco.mjtGeom.mjGEOM_CYLINDER: lambda size, axes: (
        size[0] * _flat(axes[:, 2]) + size[1] * np.abs(axes[:, 2])
    ),
}
