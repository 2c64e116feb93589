"""Which part of a mover each point of the fine grid shows: exact, from poses and triangles.

A part is a rigid body, but for two things. A lamp is so much brighter than what it sits in that a
sliver of it, gone astray, would outshine a whole pixel: each is a part of its own. And a wheel is
lit anew as it turns: where its tyre is an open ring, the spokes must not be lit as the ring's
inside is, so that each of the wheel's materials is a part.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import NEAR_M, Intrinsics, Pose
from sim.geometry.rectangles import Rectangle, rectangle_around
from sim.geometry.rigid_transform import compose_transforms
from sim.raster.scan_conversion import NOTHING, bounds, perspective, rasterise
from sim.raster.triangles import Soup
from sim.scene.lighting import OFF_EMISSION
from sim.scene.moving_objects import MovingObject

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Parts:
    """The parts of a model; the first have the numbers of the bodies.

    Attributes:
        of_geom: (geoms,) int32, number of the part that each belongs to.
        body: (parts,) int32, number of the body that each moves with.
    """

    of_geom: I32
    body: I32

    def __len__(self) -> int:
        return len(self.body)

    def bodies(self, label: I32) -> I32:
        """Labels of parts as those of their bodies; `NOTHING` stays."""
        return np.append(self.body, np.int32(NOTHING))[label]


def parts(model: mujoco.MjModel, objects: tuple[MovingObject, ...]) -> Parts:
    """Take what moves apart into bodies, lamps and the materials of open wheels."""
    of_geom = model.body_weldid[model.geom_bodyid].astype(np.int32)
    body = list(range(model.nbody))
    mesh = model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    turning = {b for obj in objects for b in turning_bodies(obj)} & set(of_geom[mesh].tolist())
    known: dict[tuple[int, int], int] = {}
    for geom in np.concatenate([np.empty(0, np.int64), *(obj.geoms for obj in objects)]):
        carrier, material = int(of_geom[geom]), int(model.geom_matid[geom])
        if material >= 0 and model.mat_emission[material] > OFF_EMISSION:
            of_geom[geom] = len(body)
            body.append(carrier)
        elif carrier in turning:
            if (carrier, material) not in known:
                known[carrier, material] = len(body)
                body.append(carrier)
            of_geom[geom] = known[carrier, material]
    return Parts(of_geom, np.array(body, np.int32))


def turning_bodies(obj: MovingObject) -> list[int]:
    """Numbers of the bodies that turn on and on in the light: a vehicle's wheels."""
    return [int(b) for b in obj.bodies if b != obj.root] if obj.has_wheels else []


@dataclass(frozen=True, eq=False)
class Outlines:
    """What moves, before a camera at rest.

    Attributes:
        movers: the triangles of all that moves.
        parts: of the model.
        pose: the camera's.
        lens: likewise.
        size: fine points per pixel and axis.
    """

    movers: Soup
    parts: Parts
    pose: Pose
    lens: Intrinsics
    size: int

    def project(self, poses: F64) -> tuple[F64, I32]:
        """The movers' triangles on the fine grid, (n, 3, 3), and the part of each.

        Args:
            poses: (bodies, 3, 4) from each body's frame into the world.
        """
        seen = self.movers.moved(compose_transforms(poses, self.pose.into))
        middle = self.lens.width * self.size / 2, self.lens.height * self.size / 2
        flat, source = perspective(seen, self.lens.focal_px * self.size, *middle, NEAR_M)
        return flat, self._part[source]

    @cached_property
    def _part(self) -> I32:
        return self.parts.of_geom[self.movers.geom]

    def of(self, obj: MovingObject) -> list[int]:
        """Numbers of an object's parts."""
        if obj.name not in self._known:
            mine = np.isin(self.parts.body, obj.bodies)
            self._known[obj.name] = [int(k) for k in np.flatnonzero(mine)]
        return self._known[obj.name]

    @cached_property
    def _known(self) -> dict[str, list[int]]:
        return {}

    def rectangles(
        self, flat: F64, part: I32, objects: tuple[MovingObject, ...]
    ) -> list[Rectangle | None]:
        """The rectangle around each object's triangles; None outside of the image."""
        span = self.span_px(flat, part)
        return [self.around(span[self.of(obj)]) for obj in objects]

    def span_px(self, flat: F64, part: I32) -> F64:
        """(parts, 4) lowest x and y, highest x and y of each part [px]; see `raster.bounds`."""
        return bounds(flat, part, len(self.parts)) / self.size

    def around(self, span: F64) -> Rectangle | None:
        """The rectangle around spans, (n, 4) [px]; None outside of the image."""
        if not np.isfinite(span).any():
            return None
        return rectangle_around(span[:, :2].min(axis=0), span[:, 2:].max(axis=0), self.lens)

    def points(
        self, flat: F64, part: I32, rectangle: Rectangle, street_nearness: F32
    ) -> tuple[I32, F32]:
        """Which mover each fine point of a rectangle shows, and how near.

        Args:
            flat: triangles as `project` gives them.
            part: of each.
            rectangle: x0, y0, x1, y1 [px].
            street_nearness: 1/depth of what never moves at all fine points, float32 [1/m].

        Returns:
            Fine points of the rectangle, int32 and float32: the part, `NOTHING` for the street; and
            1/depth [1/m].
        """
        x0, y0, x1, y1 = (self.size * edge for edge in rectangle)
        nearness = street_nearness[y0:y1, x0:x1].copy()
        label = np.full(nearness.shape, NOTHING, np.int32)
        rasterise(flat, part, x0, y0, nearness, label, True)
        return label, nearness
