"""Motions in closed form: joint positions of an object at any time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]
Addresses = npt.NDArray[np.int64]
"""Indices into `qpos`."""


class Path(Protocol):
    """Position along a straight line over time."""

    def position_m(self, t_s: float) -> float:
        """Return the position along the line [m]."""

    def speed_m_s(self, t_s: float) -> float:
        """Return the speed along the line [m/s]."""


class Motion(Protocol):
    """Motion of one object: sets its joints for any time."""

    def place(self, qpos: F64, t_s: float) -> None:
        """Set the joints of the object for a time since the target's closest approach [s]."""

    def fastest_m_s(self, t_s: float) -> float:
        """Return a bound on the speed of any point of the object [m/s]."""


@dataclass(frozen=True)
class UniformPath:
    """Motion at constant speed [m/s] that passes the origin at `passes_s` [s]."""

    speed: float
    passes_s: float

    def position_m(self, t_s: float) -> float:
        """Return the position along the line [m]."""
        return self.speed * (t_s - self.passes_s)

    def speed_m_s(self, t_s: float) -> float:  # noqa: ARG002
        """Return the speed along the line [m/s]."""
        return self.speed


@dataclass(frozen=True, eq=False)
class Rolling:
    """Motion of a vehicle whose wheels roll without slip.

    Attributes:
        path: path of the vehicle.
        travel: `qpos` index of its slide joint.
        wheels: (n,) `qpos` indices of the hinges of its wheels.
        radii_m: (n,) radii of the wheels [m].
        spokes_m: (n,) radius up to which each wheel shows its rotation: the length of its spokes
            [m]. Tyres have no visible marks.
    """

    path: Path
    travel: int
    wheels: Addresses
    radii_m: F64
    spokes_m: F64

    def place(self, qpos: F64, t_s: float) -> None:
        """Set the joints for a time [s]."""
        way_m = self.path.position_m(t_s)
        qpos[self.travel] = way_m
        qpos[self.wheels] = way_m / self.radii_m

    def fastest_m_s(self, t_s: float) -> float:
        """Return a bound on the speed of any point [m/s]: the uppermost spoke is the fastest."""
        return float(1 + np.max(self.spokes_m / self.radii_m)) * self.path.speed_m_s(t_s)


def rolling(model: mujoco.MjModel, prefix: str, path: Path) -> Rolling:
    """Return the motion of the vehicle that was attached under `prefix`.

    Its MJCF file has a slide joint "travel" and hinges "wheel_…". The origin of the vehicle is on
    the ground, so the height of a wheel's body is the radius of the wheel.
    """
    joints = [model.joint(k) for k in range(model.njnt)]
    wheels = [joint for joint in joints if joint.name.startswith(f"{prefix}wheel_")]
    bodies = [int(model.jnt_bodyid[joint.id]) for joint in wheels]
    return Rolling(
        path=path,
        travel=int(model.joint(f"{prefix}travel").qposadr[0]),
        wheels=np.array([joint.qposadr[0] for joint in wheels], np.int64),
        radii_m=np.array([model.body_pos[body, 2] for body in bodies]),
        spokes_m=np.array([_spokes_m(model, body) for body in bodies]),
    )


def _spokes_m(model: mujoco.MjModel, body: int) -> float:
    """Return how far the bars on a wheel reach from its axis, which is y [m]."""
    bars = (model.geom_bodyid == body) & (model.geom_type == mujoco.mjtGeom.mjGEOM_BOX)
    if not bars.any():
        return 0.0
    middle = np.linalg.norm(model.geom_pos[bars][:, [0, 2]], axis=1)
    return float(np.max(middle + model.geom_size[bars].max(axis=1)))
