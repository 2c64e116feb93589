"""The gait of a pedestrian in closed form: limbs that swing in step with the speed.

The phase φ is 0 when the right heel strikes the ground, and grows by 2π per stride, which is two
steps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.motion.paths import Path, UniformPath

WALK_RATIO_M_S = 0.0065 * 60
"""Walk ratio, step length over cadence [m / (steps/s)]: 6.5 mm per (step/min) (assumed). Walkers
keep it from 1 m/s upwards (Murakami and Otaka 2017); here it is kept below 1 m/s too."""
LEG_M = 0.9
"""Length from hip to sole, as in `pedestrian.xml` [m]."""
KNEE_REST_RAD, KNEE_SWING_RAD = math.radians(4), math.radians(56)
"""Flexion of the knee in stance, and the most that the swing adds: 60° in all (assumed)."""
ANKLE_SHARE = 0.85
"""Share of the tilt of the leg that the ankle cancels, so that the sole stays level (assumed)."""
SHIN_M = 0.46
"""Length from knee to sole, as in `pedestrian.xml` [m]."""
ARM_SHARE = 0.7
"""Swing of the shoulder over that of the hip (assumed)."""
ELBOW_RAD, ELBOW_SWING_RAD = math.radians(22), math.radians(10)
"""Flexion of the elbow, and its swing (assumed)."""
_STEEPEST = 3 * math.sqrt(3) / 8
"""Largest slope of ((1 − sin φ) / 2)²."""
EXCURSION_M = 0.6
"""Distance that hands and feet swing beyond their rest positions [m] (measured)."""

F64 = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Gait:
    """Joint angles of a walk at constant speed.

    Attributes:
        speed_m_s: walking speed [m/s].
    """

    speed_m_s: float

    @property
    def step_m(self) -> float:
        """Step length [m]: √(walk ratio × speed)."""
        return math.sqrt(WALK_RATIO_M_S * self.speed_m_s)

    @property
    def stride_s(self) -> float:
        """Period of the gait, two steps [s]."""
        return 2 * self.step_m / self.speed_m_s

    @property
    def hip_rad(self) -> float:
        """Largest hip angle [rad]: the one that a straight leg needs for the step."""
        return math.asin(self.step_m / (2 * LEG_M))

    def phase_rad(self, way_m: float) -> float:
        """Return the phase after a distance along the ground [rad]."""
        return math.pi * way_m / self.step_m

    def leg_rad(self, phase: float) -> tuple[float, float, float]:
        """Return the angles of hip, knee and ankle at a phase of that leg [rad]."""
        hip = self.hip_rad * math.cos(phase)
        knee = KNEE_REST_RAD + KNEE_SWING_RAD * ((1 - math.sin(phase)) / 2) ** 2
        return hip, knee, ANKLE_SHARE * (knee - hip)

    def arm_rad(self, phase: float) -> tuple[float, float]:
        """Return the angles of shoulder and elbow at the phase of the leg on that side [rad]."""
        swing = -math.cos(phase)
        return ARM_SHARE * self.hip_rad * swing, ELBOW_RAD + ELBOW_SWING_RAD * swing

    def bob_m(self, phase: float) -> float:
        """Return the height of the hips above standing [m]; lowest when the legs are spread."""
        return -LEG_M * (1 - math.cos(self.hip_rad * math.cos(phase)))


@dataclass(frozen=True, eq=False)
class Walking:
    """Motion of a pedestrian.

    Attributes:
        path: path of the pedestrian.
        gait: gait of the pedestrian.
        travel: `qpos` index of the slide joint along the path.
        bob: `qpos` index of the slide joint of the height.
        limbs: (2, 5) `qpos` indices of hip, knee, ankle, shoulder and elbow; right, then left.
    """

    path: Path
    gait: Gait
    travel: int
    bob: int
    limbs: npt.NDArray[np.int64]

    def place(self, qpos: F64, t_s: float) -> None:
        """Set the joints for a time [s]."""
        way_m = self.path.position_m(t_s)
        phase = self.gait.phase_rad(way_m)
        qpos[self.travel], qpos[self.bob] = way_m, self.gait.bob_m(phase)
        for addresses, side in zip(self.limbs, (phase, phase + math.pi), strict=True):
            qpos[addresses] = *self.gait.leg_rad(side), *self.gait.arm_rad(side)

    def fastest_m_s(self, t_s: float) -> float:
        """Return a bound on the speed of a swinging foot [m/s]."""
        rate_rad_s = 2 * math.pi / self.gait.stride_s
        swing_m = LEG_M * self.gait.hip_rad + SHIN_M * KNEE_SWING_RAD * _STEEPEST
        return self.path.speed_m_s(t_s) + rate_rad_s * swing_m


def walking(model: mujoco.MjModel, prefix: str, *, speed_m_s: float, passes_s: float) -> Walking:
    """Return the motion of the pedestrian under `prefix`, who passes x = 0 at `passes_s`."""

    def address(name: str) -> int:
        return int(model.joint(prefix + name).qposadr[0])

    parts = ("hip", "knee", "ankle", "shoulder", "elbow")
    limbs = [[address(f"{part}_{side}") for part in parts] for side in ("right", "left")]
    return Walking(
        path=UniformPath(speed_m_s, passes_s),
        gait=Gait(speed_m_s),
        travel=address("travel"),
        bob=address("bob"),
        limbs=np.array(limbs, np.int64),
    )
