"""How objects move: closed forms from the time to the positions of their joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]
Addresses = npt.NDArray[np.int64]
"""Where joints have their positions in `qpos`."""


class Path(Protocol):
    """A way along a straight line over time."""

    def position_m(self, t_s: float) -> float:
        """RelativeDirection along the line [m]."""

    def speed_m_s(self, t_s: float) -> float:
        """Its derivative [m/s]."""


class Motion(Protocol):
    """What sets the joints of one object."""

    def place(self, qpos: F64, t_s: float) -> None:
        """Set the object's joints for a time since the target's closest approach [s]."""

    def fastest_m_s(self, t_s: float) -> float:
        """A bound on the speed of any of its points [m/s]."""


@dataclass(frozen=True)
class UniformPath:
    """Constant speed [m/s], at the origin at `passes_s` [s]."""

    speed: float
    passes_s: float

    def position_m(self, t_s: float) -> float:
        """RelativeDirection along the line [m]."""
        return self.speed * (t_s - self.passes_s)

    def speed_m_s(self, t_s: float) -> float:  # noqa: ARG002
        """Its derivative [m/s]."""
        return self.speed


@dataclass(frozen=True, eq=False)
class Rolling:
    """A vehicle on wheels that roll without slip.

    Attributes:
        path: of the vehicle.
        travel: address of its slide joint.
        wheels: (n,) addresses of the wheels' hinges.
        radii_m: (n,) of the wheels.
        spokes_m: (n,) how far from the axis their spokes reach; a tyre bears no mark that turns.
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
        """The uppermost spoke of a rolling wheel outruns the vehicle."""
        return float(1 + np.max(self.spokes_m / self.radii_m)) * self.path.speed_m_s(t_s)


def rolling(model: mujoco.MjModel, prefix: str, path: Path) -> Rolling:
    """The motion of a vehicle attached under `prefix`.

    Its file has a slide joint "travel" and hinges "wheel_…", whose bodies stand as high over the
    vehicle's origin, which is on the ground, as the wheel's radius.
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
    """How far from a wheel's axis, which is its y, the bars on it reach."""
    bars = (model.geom_bodyid == body) & (model.geom_type == mujoco.mjtGeom.mjGEOM_BOX)
    if not bars.any():
        return 0.0
    middle = np.linalg.norm(model.geom_pos[bars][:, [0, 2]], axis=1)
    return float(np.max(middle + model.geom_size[bars].max(axis=1)))
