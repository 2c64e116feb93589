"""Exact depth and optical flow of every pixel at any time, from the scene's geometry alone."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import Intrinsics
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.raster import flow
from sim.raster.visibility import VisibilityMap, visibility_map
from sim.scene.scene import Scene

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int8]

RATE_STEP_S = 1e-5
"""Half the interval of the central differences that give velocities [s]. For a motion of frequency
f they neglect (2π f · 10⁻⁵)²/6 of its speed: 10⁻⁶ at 39 Hz, and 2·10⁻⁴ at 600 Hz, the highest
frequency of the fastest shake. Rounding adds less than 10⁻⁹ m/s."""
BACKGROUND = -1
"""Object number of everything that does not move, and of the sky."""


class DenseTruth:
    """Exact geometry of a scene as its camera sees it: visibility, depth, flow and displacement.

    Times are seconds since the target's closest approach. The axes of the camera's frame point
    right, down and forward. An instance must not be used by several threads at once.

    Attributes:
        scene: the scene.
        lens: intrinsics of the camera.
        soup: all triangles of the scene.
        object_of_body: (bodies,) int8 number of the object that each body belongs to, or
            `BACKGROUND`.
    """

    def __init__(self, scene: Scene, lens: Intrinsics) -> None:
        """Extract the scene's triangles.

        Args:
            scene: the scene, which is not changed.
            lens: intrinsics of the camera.
        """
        self.scene, self.lens = scene, lens
        self.object_of_body = _object_of_body(scene)
        self.soup = scene.soup
        moving = [int(b) for o in scene.objects for b in o.bodies]
        self._movers = self.soup.of_bodies(moving)
        self._static = self.soup.without_bodies(moving)
        self._static_visible: VisibilityMap | None = None
        self._data = mujoco.MjData(scene.model)

    def poses_in_camera(self, t_s: float) -> F64:
        """(bodies, 3, 4) transforms from each body's frame to the camera's frame."""
        return compose_transforms(self.poses_in_world(t_s), self.scene.pose_at(t_s).world_to_camera)

    def poses_in_world(self, t_s: float) -> F64:
        """(bodies, 3, 4) transforms from each body's frame to the world."""
        self.scene.place(self._data, t_s)
        return body_poses(self._data)

    def twists(self, t_s: float) -> F64:
        """Return each body's velocity field in the frame of the camera, which may itself shake.

        Returns:
            (bodies, 3, 4) maps from a point in the camera's frame to the velocity there of what is
            rigidly attached to the body [1/s, m/s].
        """
        before, now, after = (
            self.poses_in_camera(t) for t in (t_s - RATE_STEP_S, t_s, t_s + RATE_STEP_S)
        )
        return flow.twists_between(before, now, after, 2 * RATE_STEP_S)

    def visible(self, t_s: float) -> VisibilityMap:
        """Return the body that the middle of each pixel shows, and its nearness."""
        poses, pose = self.poses_in_world(t_s), self.scene.pose_at(t_s)
        static = self._static_visible
        if static is None or self.scene.shake is not None:
            static = self._static_visible = visibility_map(self._static, poses, pose, self.lens)
        return visibility_map(self._movers, poses, pose, self.lens, static)

    def depth_m(self, t_s: float) -> F32:
        """(height, width) float32 depth along the optical axis [m]; infinite for the sky."""
        return flow.depth_m(self.visible(t_s))

    def flow_px_s(self, t_s: float) -> F32:
        """(height, width, 2) float32 image velocity of what the middle of each pixel shows."""
        return flow.flow_px_s(self.visible(t_s), self.twists(t_s), self.lens)

    def displacement_px(self, from_s: float, to_s: float) -> F32:
        """Return how far the point shown by the middle of each pixel moves between two times.

        Args:
            from_s: time at which the pixels show the points [s].
            to_s: time to which the points are followed [s].

        Returns:
            (height, width, 2) float32, x and y [px]; see `sim.raster.flow.displacement_px`.
        """
        moves = flow.transforms_between(self.poses_in_camera(from_s), self.poses_in_camera(to_s))
        return flow.displacement_px(self.visible(from_s), moves, self.lens)


def _object_of_body(scene: Scene) -> I8:
    numbers = np.full(scene.model.nbody, BACKGROUND, np.int8)
    for k, item in enumerate(scene.objects):
        numbers[item.bodies] = k
    return numbers
