"""Ground truth of every moving object at a given time, in the image and in the world."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Intrinsics, Pose, Projection
from sim.geometry.rigid_transform import compose_transforms
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

    def __init__(self, scene: Scene, lens: Intrinsics) -> None:
        """Prepare the geometry, the silhouettes and the reference points of all moving objects.

        Args:
            scene: the scene, which is not changed.
            lens: intrinsics of the camera.

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
        poses, camera = self.geometry.poses_in_world(t_s), scene.pose_at(t_s)
        motions = self._motions(t_s, poses, camera)
        objects = tuple(
            self._object_truth(k, motions[k], poses, camera, labels, counts[k])
            for k in range(len(scene.objects))
        )
        position_m = scene.trajectory.position_m(t_s)
        return GroundTruth(t_us, scene.config.direction, position_m, objects)

    def _object_truth(
        self, k: int, motion: F64, poses: F64, camera: Pose, labels: I8, count: I64
    ) -> ObjectTruth:
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
            measure_visibility=partial(self._visibility, k, poses, camera, labels),
        )

    def _visibility(self, k: int, poses: F64, camera: Pose, labels: I8) -> float:
        in_camera = compose_transforms(poses, camera.world_to_camera)
        return self._visible_fractions[k].measure(in_camera, self._lens, labels, k)

    def _motions(self, t_s: float, poses: F64, camera: Pose) -> F64:
        """Motion of every reference point, see `_motions`; `poses` and `camera` are at `t_s`."""
        around_s = t_s - RATE_STEP_S, t_s + RATE_STEP_S
        roots = np.stack([poses[self._roots], *(self._root_poses(t) for t in around_s)])
        poses_of_camera = [camera, *map(self._scene.pose_at, around_s)]
        cameras = np.stack([pose.world_to_camera for pose in poses_of_camera])
        return _motions(self._references_m, roots, cameras, self._projection, 2 * RATE_STEP_S)

    def _root_poses(self, t_s: float) -> F64:
        return np.asarray(self.geometry.poses_in_world(t_s)[self._roots])

    def _reference_points_m(self) -> F64:
        """(objects, 3) reference points in the frames of the objects' root bodies [m]."""
        points = np.array([item.box_m.mean(axis=0) for item in self._scene.objects])
        flank_m = self._scene.flank_m(self._scene.trajectory.position_m(0.0)).mean(axis=0)
        root = self.geometry.poses_in_world(0.0)[self._roots[0]]
        points[0] = (flank_m - root[:, 3]) @ root[:, :3]
        return points


@compiled
def _motions(points: F64, roots: F64, cameras: F64, projection: Projection, apart_s: float) -> F64:
    """Describe the motions of points in the image and around the camera.

    Args:
        points: (objects, 3) points in the frames of the objects' root bodies [m].
        roots: (3, objects, 3, 4) poses of these bodies in the world at the time in question, and
            half of `apart_s` before and after it.
        cameras: (3, 3, 4) transforms from the world to the camera's frame at these times. The
            camera rotates about a fixed position.
        projection: projection of the camera.
        apart_s: time between the last two poses [s].

    Returns:
        (objects, 6): reference point in the image [px] and its velocity [px/s], rate of its bearing
        about the vertical, without sign [rad/s], and its distance [m]; see `ObjectTruth`.
    """
    focal, centre_x, centre_y = projection
    out, world, seen = np.empty((len(points), 6)), np.empty((3, 3)), np.empty((3, 3))
    for k in range(len(points)):
        for t in range(3):
            axes = cameras[t, :, :3].copy()
            point = np.empty(3)
            for i in range(3):
                point[i] = roots[t, k, i, 3]
                for j in range(3):
                    point[i] += roots[t, k, i, j] * points[k, j]
            for i in range(3):
                seen[t, i] = cameras[t, i, 3]
                for j in range(3):
                    seen[t, i] += axes[i, j] * point[j]
            for i in range(3):  # from the camera along the world's axes: the rotation undone
                world[t, i] = 0.0
                for j in range(3):
                    world[t, i] += axes[j, i] * seen[t, j]
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
