"""Part of a moving object that each sub-pixel shows, computed exactly from poses and triangles.

A part is a rigid body, with two exceptions. A lamp is a separate part: it is so much brighter than
its surroundings that a misplaced sliver of it would outshine a whole pixel. Each material of an
open wheel is a separate part, because the illumination of a wheel does not rotate with it: where
the tyre is an open ring, the spokes must not get the illumination of the ring's inner side.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import NEAR_M, Intrinsics, Pose, Projection
from sim.geometry.rectangles import Rectangle, joint_rectangles, rectangle_around
from sim.geometry.rigid_transform import compose_transforms
from sim.raster.scan_conversion import NO_LABEL, label_bounds, rasterise
from sim.raster.shared_corners import (
    SharedCorners,
    project_bodies,
    share_corners,
)
from sim.raster.triangles import TriangleSoup
from sim.scene.lighting import OFF_EMISSION
from sim.scene.moving_objects import MovingObject

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class MoverParts:
    """The parts of a model. Parts below the number of bodies have the bodies' numbers.

    Attributes:
        of_geom: (geoms,) int32, number of the part that each geom belongs to.
        body: (parts,) int32, number of the body that each part moves with.
    """

    of_geom: I32
    body: I32

    def __len__(self) -> int:
        return len(self.body)


def split_into_parts(model: mujoco.MjModel, objects: tuple[MovingObject, ...]) -> MoverParts:
    """Split moving objects into bodies, lamps and the materials of open wheels."""
    of_geom = model.body_weldid[model.geom_bodyid].astype(np.int32)
    body = list(range(model.nbody))
    mesh = model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    wheels = {b for obj in objects for b in wheel_bodies(obj)} & set(of_geom[mesh].tolist())
    known: dict[tuple[int, int], int] = {}
    for geom in np.concatenate([np.empty(0, np.int64), *(obj.geoms for obj in objects)]):
        carrier, material = int(of_geom[geom]), int(model.geom_matid[geom])
        if material >= 0 and model.mat_emission[material] > OFF_EMISSION:
            of_geom[geom] = len(body)
            body.append(carrier)
        elif carrier in wheels:
            if (carrier, material) not in known:
                known[carrier, material] = len(body)
                body.append(carrier)
            of_geom[geom] = known[carrier, material]
    return MoverParts(of_geom, np.array(body, np.int32))


def wheel_bodies(obj: MovingObject) -> list[int]:
    """Return the numbers of the bodies that rotate continuously: a vehicle's wheels."""
    return [int(b) for b in obj.wheels]


@dataclass(frozen=True, eq=False)
class MoverRaster:
    """Rasteriser of the moving objects, for a steady camera.

    Attributes:
        movers: triangles of everything that moves.
        parts: parts of the model.
        pose: pose of the camera.
        lens: intrinsics of the camera.
        supersample: sub-pixels per pixel and axis.
    """

    movers: TriangleSoup
    parts: MoverParts
    pose: Pose
    lens: Intrinsics
    supersample: int

    def project(self, poses: F64) -> tuple[F64, I32]:
        """Project the moving triangles.

        Args:
            poses: (bodies, 3, 4) transform from each body's frame into the world.

        Returns:
            (n, 3, 3) triangles on the sub-pixel grid; and (n,) the part of each.
        """
        return self.project_views(compose_transforms(poses, self.pose.world_to_camera))

    def project_views(self, views: F64) -> tuple[F64, I32]:
        """Project the moving triangles; `views` transforms each body's frame to the camera's."""
        size, lens = self.supersample, self.lens
        grid = Projection(lens.focal_px * size, lens.width * size / 2, lens.height * size / 2)
        return project_bodies(self._shared, self._part_of_triangle, views, grid, NEAR_M)

    @cached_property
    def _shared(self) -> SharedCorners:
        return share_corners(self.movers)

    @cached_property
    def _part_of_triangle(self) -> I32:
        return self.parts.of_geom[self.movers.geom]

    def parts_of(self, obj: MovingObject) -> list[int]:
        """Return the numbers of an object's parts."""
        if obj.name not in self._parts_by_name:
            mine = np.isin(self.parts.body, obj.bodies)
            self._parts_by_name[obj.name] = [int(k) for k in np.flatnonzero(mine)]
        return self._parts_by_name[obj.name]

    @cached_property
    def _parts_by_name(self) -> dict[str, list[int]]:
        return {}

    def rectangles(
        self, projected: F64, part: I32, objects: tuple[MovingObject, ...]
    ) -> list[Rectangle | None]:
        """Return the rectangle around each object; None for an object outside the image.

        Args:
            projected: triangles, from `project`.
            part: part of each triangle.
            objects: the objects.
        """
        if objects not in self._object_of_part:
            owner = np.full(len(self.parts), -1)
            for k, obj in enumerate(objects):
                owner[self.parts_of(obj)] = k
            self._object_of_part[objects] = owner
        lens, owner = self.lens, self._object_of_part[objects]
        bounds = self.bounds_px(projected, part)
        found = joint_rectangles(bounds, owner, len(objects), lens.width, lens.height).tolist()
        return [(x0, y0, x1, y1) if x1 else None for x0, y0, x1, y1 in found]

    @cached_property
    def _object_of_part(self) -> dict[tuple[MovingObject, ...], I64]:
        """Number of the object that each part belongs to, -1 for none, for tuples of objects."""
        return {}

    def bounds_px(self, projected: F64, part: I32) -> F64:
        """Return the bounding box of each part [px].

        Returns:
            (parts, 4) lowest x and y, highest x and y; see `sim.raster.scan_conversion`.
        """
        return label_bounds(projected, part, len(self.parts)) / self.supersample

    def rectangle_of(self, bounds: F64) -> Rectangle | None:
        """Return the rectangle around (n, 4) bounding boxes [px]; None outside the image."""
        if not np.isfinite(bounds).any():
            return None
        return rectangle_around(bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0), self.lens)

    def rasterise(
        self, projected: F64, part: I32, rectangle: Rectangle, background_nearness: F32
    ) -> tuple[I32, F32]:
        """Find the moving part that each sub-pixel of a rectangle shows.

        Args:
            projected: triangles, from `project`.
            part: part of each triangle.
            rectangle: x0, y0, x1, y1 [px].
            background_nearness: 1/depth of the background at all sub-pixels, float32 [1/m].

        Returns:
            For each sub-pixel of the rectangle: int32 part, `NO_LABEL` for the background; and
            float32 1/depth [1/m].
        """
        x0, y0, x1, y1 = (self.supersample * edge for edge in rectangle)
        nearness = background_nearness[y0:y1, x0:x1].copy()
        label = np.full(nearness.shape, NO_LABEL, np.int32)
        rasterise(projected, part, x0, y0, nearness, label, True)
        return label, nearness
