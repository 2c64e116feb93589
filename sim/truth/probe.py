"""Ground truth of every moving object at a given time, in the image and in the world."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import mujoco
import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Intrinsics, Projection
from sim.motion.computed_ahead import ComputedAhead
from sim.raster.visible_fraction import VisibleFraction
from sim.scene.scene import Scene
from sim.truth.dense_truth import RATE_STEP_S, DenseTruth
from sim.truth.ground_truth import GroundTruth, ObjectTruth
from sim.truth.object_labels import AREA, box_of, centroid_of, label_objects

F64 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int8]
I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]


class TruthProbe:
    """Measures the ground truth of a scene at any time.

    An instance must not be used by several threads at once.

    Attributes:
        geometry: dense ground truth of the same scene.
    """

    def __init__(self, scene: Scene, lens: Intrinsics, times_s: Sequence[float] = ()) -> None:
        """Prepare the geometry, the silhouettes and the reference points of all moving objects.

        Args:
            scene: the scene, which is not changed.
            lens: intrinsics of the camera.
            times_s: times at which the truth will be measured, increasing [s]. Measuring at these
                is faster, and gives the same.

        Raises:
            SceneConfigError: the lens is not symmetric.
        """
        lens.require_symmetry()
        self.geometry = DenseTruth(scene, lens)
        self._scene, self._lens = scene, lens
        self._visible_fractions = [
            VisibleFraction(self.geometry.soup.of_bodies(item.bodies)) for item in scene.objects
        ]
        self._roots = np.array([item.root for item in scene.objects])
        self._references_m = self._reference_points_m()
        self._projection = Projection(lens.focal_px, *lens.centre_px)
        bodies = scene.model.nbody
        self._state = mujoco.MjData(scene.model)
        self._origins_m, self._axes = np.empty((3, bodies, 3)), np.empty((3, bodies, 9))
        self._cameras = np.empty((3, 3, 4))
        self._motions = ComputedAhead(self._motions_at, times_s)

    def measure(self, t_us: int, t_s: float, body: I32) -> GroundTruth:
        """Measure the ground truth at one time.

        Args:
            t_us: time since the start of the sequence [µs].
            t_s: the same instant as time since closest approach [s].
            body: (height, width) int32 rigid body that the middle of each pixel shows at that
                time; see `sim.raster.visibility.VisibilityMap`.
        """
        scene = self._scene
        labels, counts = label_objects(body, self.geometry.object_of_body, len(scene.objects))
        motions = self._motions.at(t_s)
        objects = tuple(
            self._object_truth(k, t_s, motions[k], labels, counts[k])
            for k in range(len(scene.objects))
        )
        position_m = scene.trajectory.position_m(t_s)
        return GroundTruth(t_us, scene.config.direction, position_m, objects)

    def _object_truth(self, k: int, t_s: float, motion: F64, labels: I8, count: I64) -> ObjectTruth:
        """Collect the truth of object `k`; `count` is its row of counts from `label_objects`."""
        item, seen = self._scene.objects[k], count[AREA] > 0
        return ObjectTruth(
            name=item.name,
            kind=item.kind,
            reference_px=motion[:2],
            image_velocity_px_s=motion[2:4],
            angular_velocity_rad_s=float(motion[4]),
            distance_m=float(motion[5]),
            bounding_box_px=box_of(count) if seen else None,
            centroid_px=centroid_of(count) if seen else None,
            labels=labels,
            number=k,
            measure_visibility=partial(self._visibility, k, t_s, labels),
        )

    def _visibility(self, k: int, t_s: float, labels: I8) -> float:
        views = self.geometry.poses_in_camera(t_s)
        return self._visible_fractions[k].measure(views, self._lens, labels, k)

    def _motions_at(self, t_s: float) -> F64:
        """Motion of every reference point at a time, see `_motions`."""
        state = self._state
        for k, moment_s in enumerate((t_s, t_s - RATE_STEP_S, t_s + RATE_STEP_S)):
            self._scene.place(state, moment_s)
            self._origins_m[k], self._axes[k] = state.xpos, state.xmat
            self._cameras[k] = self._scene.pose_at(moment_s).world_to_camera
        bodies = self._roots, self._origins_m, self._axes
        return _motions(self._references_m, *bodies, self._cameras, self._projection)

    def _reference_points_m(self) -> F64:
        """(objects, 3) reference points in the frames of the objects' root bodies [m]."""
        points = np.array([item.box_m.mean(axis=0) for item in self._scene.objects])
        flank_m = self._scene.flank_m(self._scene.trajectory.position_m(0.0)).mean(axis=0)
        root = self.geometry.poses_in_world(0.0)[self._roots[0]]
        points[0] = (flank_m - root[:, 3]) @ root[:, :3]
        return points


@compiled
def _motions(
    points: F64, roots: I64, origins_m: F64, axes: F64, cameras: F64, projection: Projection
) -> F64:
    """Describe the motions of points in the image and around the camera.

    Args:
        points: (objects, 3) points in the frames of the objects' root bodies [m].
        roots: (objects,) numbers of these bodies.
        origins_m: (3, bodies, 3) origins of all bodies in the world at the time in question, and
            `RATE_STEP_S` before and after it [m].
        axes: (3, bodies, 9) rotation matrices of all bodies at these times, row by row.
        cameras: (3, 3, 4) transforms from the world to the camera's frame at these times. The
            camera rotates about a fixed position.
        projection: projection of the camera.

    Returns:
        (objects, 6): reference point in the image [px] and its velocity [px/s], rate of its bearing
        about the vertical, without sign [rad/s], and its distance [m]; see `ObjectTruth`.
    """
    focal, centre_x, centre_y = projection
    apart_s = 2 * RATE_STEP_S
    out, point = np.empty((len(points), 6)), np.empty(3)
    world, seen = np.empty((3, 3)), np.empty((3, 3))
    for k in range(len(points)):
        for t in range(3):
            for i in range(3):
                point[i] = origins_m[t, roots[k], i]
                for j in range(3):
                    point[i] += axes[t, roots[k], 3 * i + j] * points[k, j]
            for i in range(3):
                seen[t, i] = cameras[t, i, 3]
                for j in range(3):
                    seen[t, i] += cameras[t, i, j] * point[j]
            for i in range(3):  # from the camera along the world's axes: the rotation undone
                world[t, i] = 0.0
                for j in range(3):
                    world[t, i] += cameras[t, j, i] * seen[t, j]
        x, y, z = world[0, 0], world[0, 1], world[0, 2]
        turn, rate = (world[2] - world[1]) / apart_s, (seen[2] - seen[1]) / apart_s
        depth = seen[0, 2] if seen[0, 2] > 0 else np.nan
        right, down = seen[0, 0] / depth, seen[0, 1] / depth
        out[k, 0], out[k, 1] = centre_x + focal * right, centre_y + focal * down
        out[k, 2] = focal / depth * (rate[0] - right * rate[2])
        out[k, 3] = focal / depth * (rate[1] - down * rate[2])
        out[k, 4] = abs(x * turn[1] - y * turn[0]) / (x * x + y * y)
        out[k, 5] = math.sqrt(x * x + y * y + z * z)
    return out
