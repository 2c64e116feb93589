"""Ground truth of every moving object at a given time, in the image and in the world."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rectangles import Rectangle
from sim.geometry.rigid_transform import compose_transforms
from sim.raster.visible_fraction import VisibleFraction
from sim.scene.scene import Scene
from sim.truth.dense_truth import RATE_STEP_S, DenseTruth
from sim.truth.ground_truth import GroundTruth, ObjectTruth

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

    def measure(self, t_us: int, t_s: float, body: I32) -> GroundTruth:
        """Measure the ground truth at one time.

        Args:
            t_us: time since the start of the sequence [µs].
            t_s: the same instant as time since closest approach [s].
            body: (height, width) int32 rigid body that the middle of each pixel shows at that
                time; see `sim.raster.visibility.VisibilityMap`.
        """
        scene = self._scene
        labels, counts = _label(body, self.geometry.object_of_body, len(scene.objects))
        poses, camera = self.geometry.poses_in_world(t_s), scene.pose_at(t_s)
        motions = self._motions(t_s, poses, camera)
        in_camera = compose_transforms(poses, camera.world_to_camera)
        objects = tuple(
            self._object_truth(k, motions[k], in_camera, labels, counts[k])
            for k in range(len(scene.objects))
        )
        position_m = scene.trajectory.position_m(t_s)
        return GroundTruth(t_us, scene.config.direction, position_m, objects)

    def _object_truth(
        self, k: int, motion: _Motion, in_camera: F64, labels: I8, count: I64
    ) -> ObjectTruth:
        """Collect the ground truth of object `k`; `count` is its row of counts from `_label`."""
        item, seen = self._scene.objects[k], count[_AREA] > 0
        visibility = 0.0
        if seen:
            visibility = self._visible_fractions[k].measure(in_camera, self._lens, labels, k)
        return ObjectTruth(
            name=item.name,
            kind=item.kind,
            reference_px=motion.reference_px,
            image_velocity_px_s=motion.image_velocity_px_s,
            angular_velocity_rad_s=motion.angular_velocity_rad_s,
            distance_m=motion.distance_m,
            visibility=visibility,
            bounding_box_px=_box(count) if seen else None,
            centroid_px=_centroid(count) if seen else None,
            labels=labels,
            number=k,
        )

    def _motions(self, t_s: float, poses: F64, camera: Pose) -> list[_Motion]:
        """Motion of every reference point; `poses` and `camera` are those at `t_s`."""
        around_s = t_s - RATE_STEP_S, t_s + RATE_STEP_S
        roots = np.stack([poses[self._roots], *(self._root_poses(t) for t in around_s)])
        cameras = [camera, *map(self._scene.pose_at, around_s)]
        world, in_camera = self._references_from_camera(roots, cameras)
        world_rates, camera_rates = ((p[2] - p[1]) / (2 * RATE_STEP_S) for p in (world, in_camera))
        return [
            _motion(world[0, k], in_camera[0, k], world_rates[k], camera_rates[k], self._lens)
            for k in range(len(self._roots))
        ]

    def _root_poses(self, t_s: float) -> F64:
        return np.asarray(self.geometry.poses_in_world(t_s)[self._roots])

    def _references_from_camera(self, roots: F64, cameras: list[Pose]) -> tuple[F64, F64]:
        """Vectors from the camera to the reference points at several times [m].

        Args:
            roots: (times, objects, 3, 4) poses of the objects' root bodies in the world.
            cameras: (times,) poses of the camera.

        Returns:
            (times, objects, 3) along the world's axes, and along the camera's axes.
        """
        points = (roots[..., :3] @ self._references_m[..., None])[..., 0] + roots[..., 3]
        offsets = points - np.array([[camera.position_m] for camera in cameras])
        axes = np.array([camera.world_to_camera[:, :3] for camera in cameras])
        return offsets, offsets @ axes.swapaxes(-1, -2)

    def _reference_points_m(self) -> F64:
        """(objects, 3) reference points in the frames of the objects' root bodies [m]."""
        points = np.array([item.box_m.mean(axis=0) for item in self._scene.objects])
        flank_m = self._scene.flank_m(self._scene.trajectory.position_m(0.0)).mean(axis=0)
        root = self.geometry.poses_in_world(0.0)[self._roots[0]]
        points[0] = (flank_m - root[:, 3]) @ root[:, :3]
        return points


@dataclass(frozen=True, eq=False)
class _Motion:
    """Motion of one object's reference point; see `ObjectTruth`."""

    reference_px: F64
    image_velocity_px_s: F64
    angular_velocity_rad_s: float
    distance_m: float


def _motion(
    world_axes: F64, camera_axes: F64, world_rate: F64, camera_rate: F64, lens: Intrinsics
) -> _Motion:
    """Describe the motion of a point in the image and around the camera.

    Args:
        world_axes: (3,) vector from the camera to the point along the world's axes [m].
        camera_axes: (3,) the same vector along the camera's axes [m].
        world_rate: (3,) rate of `world_axes` [m/s].
        camera_rate: (3,) rate of `camera_axes` [m/s].
        lens: intrinsics of the camera.
    """
    x, y, z = (float(part) for part in world_axes)
    bearing_rate = abs(x * world_rate[1] - y * world_rate[0]) / (x * x + y * y)
    depth = float(camera_axes[2]) if camera_axes[2] > 0 else math.nan
    slope = camera_axes[:2] / depth
    return _Motion(
        reference_px=np.array([lens.width / 2, lens.height / 2]) + lens.focal_px * slope,
        image_velocity_px_s=lens.focal_px / depth * (camera_rate[:2] - slope * camera_rate[2]),
        angular_velocity_rad_s=float(bearing_rate),
        distance_m=math.sqrt(x * x + y * y + z * z),
    )


_AREA = 4
"""Column of the counts that holds the number of pixels."""


@compiled
def _label(body: I32, object_of_body: I8, objects: int) -> tuple[I8, I64]:
    """Label each pixel with its object, and sum up the pixels of each object.

    Args:
        body: (height, width) body that each pixel shows, -1 for the sky.
        object_of_body: (bodies,) number of the object that each body belongs to, -1 for none.
        objects: number of objects.

    Returns:
        (height, width) int8 labels, the number of the object, -1 for none; and (objects, 7) int64
        counts: lowest column and row, highest column and row (half-open), number of pixels, sum of
        their columns and sum of their rows.
    """
    height, width = body.shape
    labels = np.full((height, width), -1, np.int8)
    counts = np.zeros((objects, 7), np.int64)
    counts[:, 0], counts[:, 1] = width, height
    for row in range(height):
        highest = np.int32(0)
        for column in range(width):
            highest = max(highest, body[row, column])
        if highest == 0:
            continue
        end = 0
        while end < width:  # whole runs of equal pixels are faster than single ones
            start, shown = end, body[row, end]
            while end < width and body[row, end] == shown:
                end += 1
            k = object_of_body[shown] if shown > 0 else np.int8(-1)
            if k < 0:
                continue
            labels[row, start:end] = k
            counts[k, 0] = min(counts[k, 0], start)
            counts[k, 1] = min(counts[k, 1], row)
            counts[k, 2] = max(counts[k, 2], end)
            counts[k, 3] = max(counts[k, 3], row + 1)
            counts[k, 4] += end - start
            counts[k, 5] += (start + end - 1) * (end - start) // 2
            counts[k, 6] += row * (end - start)
    return labels, counts


def _box(count: I64) -> Rectangle:
    return int(count[0]), int(count[1]), int(count[2]), int(count[3])


def _centroid(count: I64) -> F64:
    return np.asarray(count[5:] / count[_AREA] + 0.5)
