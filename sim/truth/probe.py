"""What is so at a time in a scene: its moving objects, each measured in the image and the world."""

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
    """Knows the truth about a scene at any time. Not for several threads at once."""

    def __init__(self, scene: Scene, lens: Intrinsics) -> None:
        """Prepare.

        Args:
            scene: what is seen; stays as it is.
            lens: the camera's.
        """
        self.geometry = DenseTruth(scene, lens)
        self._scene, self._lens = scene, lens
        self._visible_fractions = [
            VisibleFraction(self.geometry.soup.of_bodies(item.bodies)) for item in scene.objects
        ]
        self._roots = np.array([item.root for item in scene.objects])
        self._references_m = self._find_references()

    def at(self, t_us: int, t_s: float, body: I32) -> GroundTruth:
        """The truth at a time.

        Args:
            t_us: time since the start of the sequence [µs].
            t_s: the same instant, since closest approach [s].
            body: (height, width) int32, the rigid body that each pixel's middle shows then; see
                `sim.raster.visibility.VisibilityMap`.
        """
        scene = self._scene
        labels, counts = _count(body, self.geometry.object_of, len(scene.objects))
        poses, pose = self.geometry.poses(t_s), scene.pose_at(t_s)
        motions, views = self._motions(t_s, poses, pose), compose_transforms(poses, pose.into)
        objects = tuple(
            self._truth_of(k, motions[k], views, labels, counts[k])
            for k in range(len(scene.objects))
        )
        position_m = scene.trajectory.position_m(t_s)
        return GroundTruth(t_us, scene.config.direction, position_m, objects)

    def _truth_of(self, k: int, motion: _Motion, views: F64, labels: I8, count: I64) -> ObjectTruth:
        """What is so of object `k`, whose row of `_count` is given."""
        item, seen = self._scene.objects[k], count[_AREA] > 0
        visibility = 0.0
        if seen:
            visibility = self._visible_fractions[k].measure(views, self._lens, labels, k)
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

    def _motions(self, t_s: float, poses: F64, pose: Pose) -> list[_Motion]:
        """Where the objects' references are, and how they move; poses are those at the time."""
        around = t_s - RATE_STEP_S, t_s + RATE_STEP_S
        roots = np.stack([poses[self._roots], *(self._root_poses(t) for t in around)])
        apart, seen = self._references(roots, [pose, *map(self._scene.pose_at, around)])
        rates, seen_rates = ((p[2] - p[1]) / (2 * RATE_STEP_S) for p in (apart, seen))
        return [
            _motion(apart[0, k], seen[0, k], rates[k], seen_rates[k], self._lens)
            for k in range(len(self._roots))
        ]

    def _root_poses(self, t_s: float) -> F64:
        return np.asarray(self.geometry.poses(t_s)[self._roots])

    def _references(self, roots: F64, cameras: list[Pose]) -> tuple[F64, F64]:
        """References from the camera at several times [m].

        Args:
            roots: (times, objects, 3, 4) of the objects' root bodies in the world.
            cameras: (times,) the camera's.

        Returns:
            (times, objects, 3) along the world's axes, and along the camera's.
        """
        world = (roots[..., :3] @ self._references_m[..., None])[..., 0] + roots[..., 3]
        apart = world - np.array([[camera.position_m] for camera in cameras])
        axes = np.array([camera.into[:, :3] for camera in cameras])
        return apart, apart @ axes.swapaxes(-1, -2)

    def _find_references(self) -> F64:
        """(objects, 3) references in the frames of the objects' roots [m]."""
        found = np.array([item.box_m.mean(axis=0) for item in self._scene.objects])
        flank_m = self._scene.flank_m(self._scene.trajectory.position_m(0.0)).mean(axis=0)
        root = self.geometry.poses(0.0)[self._roots[0]]
        found[0] = (flank_m - root[:, 3]) @ root[:, :3]
        return found


@dataclass(frozen=True, eq=False)
class _Motion:
    """How one object's reference moves; see `ObjectTruth`."""

    reference_px: F64
    image_velocity_px_s: F64
    angular_velocity_rad_s: float
    distance_m: float


def _motion(apart: F64, seen: F64, apart_rate: F64, seen_rate: F64, lens: Intrinsics) -> _Motion:
    """What a place and its rate are in the image and around the camera.

    Args:
        apart: (3,) from the camera, along the world's axes [m].
        seen: (3,) the same in the camera's frame [m].
        apart_rate: (3,) rate of `apart` [m/s].
        seen_rate: (3,) rate of `seen` [m/s].
        lens: the camera's.
    """
    x, y, z = (float(part) for part in apart)
    turning = abs(x * apart_rate[1] - y * apart_rate[0]) / (x * x + y * y)
    depth = float(seen[2]) if seen[2] > 0 else math.nan
    slope = seen[:2] / depth
    return _Motion(
        reference_px=np.array([lens.width / 2, lens.height / 2]) + lens.focal_px * slope,
        image_velocity_px_s=lens.focal_px / depth * (seen_rate[:2] - slope * seen_rate[2]),
        angular_velocity_rad_s=float(turning),
        distance_m=math.sqrt(x * x + y * y + z * z),
    )


_AREA = 4
"""Column of `_count`."""


@compiled
def _count(body: I32, object_of: I8, objects: int) -> tuple[I8, I64]:
    """Which object each pixel shows, and what each object's pixels add up to.

    Args:
        body: (height, width), -1 for the sky.
        object_of: (bodies,) the object that each body belongs to, -1 for none.
        objects: how many there are.

    Returns:
        (height, width) the object's number, -1 for none; and (objects, 7): lowest column and row,
        highest column and row, half-open, number of pixels, and sums of their columns and rows.
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
        while end < width:  # run by run
            start, what = end, body[row, end]
            while end < width and body[row, end] == what:
                end += 1
            k = object_of[what] if what > 0 else np.int8(-1)
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
