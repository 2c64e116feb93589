"""A scene's geometry at any time, as its camera has it before it: exact, and without light."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import Intrinsics
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.raster import flow
from sim.raster.triangles import triangle_soup
from sim.raster.visibility import VisibilityMap, visibility_map
from sim.scene.scene import Scene

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int8]

RATE_STEP_S = 1e-5
"""Half the time over which poses are differenced for velocities. What the cut-off series leaves out
of a motion at f Hz is (2π f · 10⁻⁵)²/6 of its speed: 10⁻⁶ at 39 Hz, and 2·10⁻⁴ at 600 Hz, the
fastest tone of the fastest shake; rounding adds less than 10⁻⁹ m/s."""
BACKGROUND = -1
"""Number of the object that what stands still belongs to, and the sky."""


class DenseTruth:
    """Where everything in a scene is, and how it moves, in its camera's frame.

    Times are seconds since the target's closest approach. The camera's frame is right, down,
    forward. Not for several threads at once.
    """

    def __init__(self, scene: Scene, lens: Intrinsics) -> None:
        """Take the scene apart into triangles.

        Args:
            scene: what is seen; stays as it is.
            lens: the camera's.
        """
        self.scene, self.lens = scene, lens
        self.object_of = objects_of_bodies(scene)
        self.soup = triangle_soup(scene.model)
        moving = [int(b) for o in scene.objects for b in o.bodies]
        self._movers = self.soup.of_bodies(moving)
        self._still_soup = self.soup.without_bodies(moving)
        self._still: VisibilityMap | None = None
        self._data = mujoco.MjData(scene.model)

    def views(self, t_s: float) -> F64:
        """(bodies, 3, 4) from each body's frame into the camera's."""
        return compose_transforms(self.poses(t_s), self.scene.pose_at(t_s).into)

    def poses(self, t_s: float) -> F64:
        """(bodies, 3, 4) from each body's frame into the world."""
        self.scene.place(self._data, t_s)
        return body_poses(self._data)

    def twists(self, t_s: float) -> F64:
        """(bodies, 3, 4) from a place in the camera's frame to the velocity there [1/s, m/s].

        Of what is rigidly joined to each body, as the camera, which may shake, sees it.
        """
        before, after = self.views(t_s - RATE_STEP_S), self.views(t_s + RATE_STEP_S)
        return flow.twists_between(before, self.views(t_s), after, 2 * RATE_STEP_S)

    def visible(self, t_s: float) -> VisibilityMap:
        """What each pixel's middle shows."""
        poses, pose = self.poses(t_s), self.scene.pose_at(t_s)
        still = self._still
        if still is None or self.scene.shake is not None:
            still = self._still = visibility_map(self._still_soup, poses, pose, self.lens)
        return visibility_map(self._movers, poses, pose, self.lens, still)

    def depth_m(self, t_s: float) -> F32:
        """(height, width) float32 depth along the optical axis [m]; infinite for the sky."""
        return flow.depth_m(self.visible(t_s))

    def flow_px_s(self, t_s: float) -> F32:
        """(height, width, 2) float32 velocity in the image of what each pixel's middle shows."""
        return flow.flow_px_s(self.visible(t_s), self.twists(t_s), self.lens)

    def displacement_px(self, from_s: float, to_s: float) -> F32:
        """How far what each pixel's middle shows at one time has gone at another.

        Returns:
            (height, width, 2) float32, x and y [px]; see `sim.raster.flow.displacement_px`.
        """
        moves = flow.transforms_between(self.views(from_s), self.views(to_s))
        return flow.displacement_px(self.visible(from_s), moves, self.lens)


def objects_of_bodies(scene: Scene) -> I8:
    """(bodies,) int8 which of the scene's objects each body belongs to, or `BACKGROUND`."""
    found = np.full(scene.model.nbody, BACKGROUND, np.int8)
    for k, item in enumerate(scene.objects):
        found[item.bodies] = k
    return found
