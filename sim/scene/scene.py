"""The scene of a crossing: a compiled MuJoCo model, its moving objects and its camera."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from sim.config import CrossingConfig, Lighting
from sim.geometry.pinhole import Pose
from sim.motion.camera_shake import Shake, camera_shake
from sim.motion.paths import Motion
from sim.motion.trajectory import Trajectory
from sim.raster.triangles import TriangleSoup, triangle_soup
from sim.scene import lighting
from sim.scene.lighting import Flicker
from sim.scene.movers import add_movers, find_movers, heading
from sim.scene.moving_objects import MovingObject, box_corners_m
from sim.scene.street import build_street
from sim.scene.trees import Tree
from sim.scene.vehicles import FLANK_M

CAMERA_HEIGHT_M = 1.2
"""Height of the camera above the road, on a tripod [m] (assumed)."""

_ROLL_RAD = {
    Direction.RIGHT: 0.0,
    Direction.LEFT: 0.0,
    Direction.UP: math.pi / 2,
    Direction.DOWN: -math.pi / 2,
}

F64 = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene whose state can be set for any time.

    Times are seconds since the closest approach of the target.

    Attributes:
        model: compiled model, with colours as authored.
        pose: pose of the camera at rest.
        config: configuration of the crossing.
        trajectory: trajectory of the target.
        objects: moving objects, the target first.
        motions: motion of each of `objects`.
        shake: rotation of the camera over time; None if the camera does not shake.
        flicker: flicker of the lamps on the mains; None if they do not flicker.
        flickering_lights: (k,) numbers of the lights on the mains: the street lamps.
        flickering_materials: (k,) numbers of the materials that glow with them: lamp lenses and lit
            windows.
    """

    model: mujoco.MjModel
    pose: Pose
    config: CrossingConfig
    trajectory: Trajectory
    objects: tuple[MovingObject, ...]
    motions: tuple[Motion, ...]
    shake: Shake | None
    flicker: Flicker | None
    flickering_lights: Numbers
    flickering_materials: Numbers

    @cached_property
    def soup(self) -> TriangleSoup:
        """The triangles of everything that is rendered."""
        return triangle_soup(self.model)

    @property
    def target(self) -> MovingObject:
        """The vehicle whose motion a detector should report."""
        return self.objects[0]

    @property
    def heading(self) -> int:
        """+1 if the target drives along the world's x, -1 if against it."""
        return heading(self.config.direction)

    def place(self, data: mujoco.MjData, t_s: float) -> None:
        """Set every joint for a time [s] and compute the poses of bodies and lights."""
        for motion in self.motions:
            motion.place(data.qpos, t_s)
        self._update(data)

    def reach_m(self, item: MovingObject, half_view_rad: float) -> float:
        """Return the distance along the road beyond which an object's box is out of view [m]."""
        (back, right, _), (front, left, _) = item.box_m
        depth_m = self._middle_depth_m(item) + float(max(-right, left))
        return depth_m * math.tan(half_view_rad) + float(max(-back, front))

    def _middle_depth_m(self, item: MovingObject) -> float:
        return float(self.model.body_pos[item.root, 1] - self.pose.position_m[1])

    def _near_depth_m(self, item: MovingObject) -> float:
        (_, right, _), (_, left, _) = item.box_m
        return self._middle_depth_m(item) - float(max(-right, left))

    def pose_at(self, t_s: float) -> Pose:
        """Return the pose of the camera at a time [s]."""
        return self.pose if self.shake is None else self.shake.turned(self.pose, t_s)

    def flicker_factor(self, t_s: float) -> float:
        """Return the luminous flux of the flickering lamps at a time [s], relative to its mean."""
        return 1.0 if self.flicker is None else self.flicker.factor(t_s)

    def fastest_px_s(
        self, t_s: float, focal_px: float, among: Collection[str] | None = None
    ) -> float:
        """Return a bound on the image speed of anything near the middle of the image [px/s].

        Args:
            t_s: time [s].
            focal_px: focal length of the lens [px].
            among: names of the objects to include; None: all.
        """
        rates = [
            motion.fastest_m_s(t_s) / self._near_depth_m(item)
            for item, motion in zip(self.objects, self.motions, strict=True)
            if among is None or item.name in among
        ]
        turning = 0.0 if self.shake is None else self.shake.fastest_rad_s(t_s)
        return focal_px * (max(rates, default=0.0) + turning)

    def body_corners_m(self, position_m: float) -> F64:
        """Return the (8, 3) world corners of the target's box at a position along its path [m]."""
        return self._in_world(box_corners_m(self.target.box_m), position_m)

    def flank_m(self, position_m: float) -> F64:
        """Return the (4, 3) world corners of the near flank at a position along the path [m].

        The flank is a rectangle that is centred on the target's origin along the road.
        """
        (back, _, low), (front, _, high) = self.target.box_m
        half = max(-back, front)
        ends = [(x, 0.0, z) for x in (-half, half) for z in (low, high)]
        corners = self._in_world(np.array(ends), position_m)
        corners[:, 1] = -FLANK_M
        return corners

    def _in_world(self, points_m: F64, position_m: float) -> F64:
        """Transform points of the target's frame to the world, at a position along its path."""
        y_m = float(self.model.body_pos[self.target.root, 1])
        forward = np.array([self.heading, self.heading, 1.0])
        shift = np.array([self.heading * position_m, y_m, 0.0])
        return np.asarray(points_m * forward + shift)

    def _update(self, data: mujoco.MjData) -> None:
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_camlight(self.model, data)


def build_scene(config: CrossingConfig) -> Scene:
    """Build and compile the scene of a crossing.

    Raises:
        SceneConfigError: an asset file is missing.
    """
    spec, trees = _build_spec(config)
    model = spec.compile()
    pose = Pose(np.array([0.0, -(config.distance + FLANK_M), CAMERA_HEIGHT_M]))
    trajectory = Trajectory(config.omega_rad_s, config.distance, config.profile)
    moving = find_movers(model, config, trajectory, trees)
    extra = config.distractors
    return Scene(
        model=model,
        pose=pose.rolled(_ROLL_RAD[config.direction]),
        config=config,
        trajectory=trajectory,
        objects=tuple(item for item, _ in moving),
        motions=tuple(motion for _, motion in moving),
        shake=camera_shake(extra.shake_rms_deg, extra.shake_corner_hz, extra.seed)
        if extra.shakes
        else None,
        flicker=Flicker(extra.flicker_hz, extra.flicker_depth)
        if extra.flickers and config.lighting is not Lighting.DAY
        else None,
        flickering_lights=_named([model.light(k).name for k in range(model.nlight)], "street_lamp"),
        flickering_materials=_named([model.mat(k).name for k in range(model.nmat)], "mains_"),
    )


def build_spec(config: CrossingConfig) -> mujoco.MjSpec:
    """Build the model of a scene (street, vehicles, lights) without compiling it."""
    return _build_spec(config)[0]


def _build_spec(config: CrossingConfig) -> tuple[mujoco.MjSpec, tuple[Tree, ...]]:
    dark, windy = config.lighting is not Lighting.DAY, config.distractors.wind_grade > 0
    spec, trees = build_street(config.street_seed, dark=dark, windy=windy)
    add_movers(spec, config)
    lighting.add_lights(spec, config)
    return spec, trees


def _named(names: list[str], prefix: str) -> Numbers:
    return np.array([k for k, name in enumerate(names) if name.startswith(prefix)], np.int64)
