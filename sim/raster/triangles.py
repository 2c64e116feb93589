"""The triangles of a MuJoCo model: exactly the facets that the renderer renders."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.errors import SceneConfigError
from sim.raster.scan_conversion import transform_triangles

INFINITE_PLANE_HALF_SIDE_M = 50.0
"""Half side of the square that stands for a plane without a size [m] (assumed)."""

F64 = npt.NDArray[np.float64]
Triangles = npt.NDArray[np.float64]
"""(n, 3, 3): triangle, corner, x y z [m]. Corners run anticlockwise as seen from outside."""


@dataclass(frozen=True, eq=False)
class TriangleSoup:
    """All visible triangles of a model, each in the frame of its rigid body.

    Attributes:
        triangles_m: (n, 3, 3) float64, in the body's frame [m].
        body: (n,) int32, number of the triangle's rigid body; 0 for what is fixed to the world.
        geom: (n,) int32, number of the triangle's geom.
    """

    triangles_m: Triangles
    body: npt.NDArray[np.int32]
    geom: npt.NDArray[np.int32]

    def of_bodies(self, bodies: npt.ArrayLike) -> TriangleSoup:
        """Return the triangles of the given bodies."""
        return self.subset(np.isin(self.body, bodies))

    def without_bodies(self, bodies: npt.ArrayLike) -> TriangleSoup:
        """Return the triangles of all bodies except the given ones."""
        return self.subset(~np.isin(self.body, bodies))

    def subset(self, mask: npt.NDArray[np.bool_]) -> TriangleSoup:
        """Return the triangles that an (n,) bool mask selects."""
        return TriangleSoup(self.triangles_m[mask], self.body[mask], self.geom[mask])

    def transformed(self, transforms: F64) -> Triangles:
        """Return the triangles after the transforms of their bodies, (bodies, 3, 4)."""
        return np.asarray(transform_triangles(self.triangles_m, self.body, transforms))


def triangle_soup(model: mujoco.MjModel) -> TriangleSoup:
    """Return the visible geoms of a model as triangles.

    Args:
        model: model of boxes, cylinders, capsules, ellipsoids, spheres, meshes and planes.

    Raises:
        SceneConfigError: the model has a geom of another type.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    rigid = model.body_weldid[model.geom_bodyid]
    visible = np.flatnonzero(model.geom_rgba[:, 3] > 0)
    by_geom = [_in_body_frame(model, data, int(k), int(rigid[k])) for k in visible]
    counts = [len(triangles) for triangles in by_geom]
    return TriangleSoup(
        np.concatenate([*by_geom, np.empty((0, 3, 3))]),
        np.repeat(rigid[visible], counts).astype(np.int32),
        np.repeat(visible, counts).astype(np.int32),
    )


def _in_body_frame(model: mujoco.MjModel, data: mujoco.MjData, geom: int, body: int) -> Triangles:
    world = geom_triangles(model, data, geom)
    return np.asarray((world - data.xpos[body]) @ data.xmat[body].reshape(3, 3))


def unit_normals(triangles: Triangles) -> F64:
    """Return the unit normals, (n, 3). The normal of a triangle without area is zero."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(across, axis=1, keepdims=True)
    normals: F64 = np.divide(across, length, out=np.zeros_like(across), where=length > 0)
    return normals


def geom_triangles(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Triangles:
    """Return a geom's triangles in the world frame."""
    kind = mujoco.mjtGeom(model.geom_type[geom])
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        local = _mesh(model, int(model.geom_dataid[geom]))
    elif kind in _SHAPES:
        quality = model.vis.quality
        local = _SHAPES[kind](model.geom_size[geom], quality.numslices, quality.numstacks)
    else:
        allowed = ", ".join(shape.name for shape in (*_SHAPES, mujoco.mjtGeom.mjGEOM_MESH))
        raise SceneConfigError(
            f"geom {geom} has the type {kind.name}, which cannot be converted to triangles. "
            f"Allowed are {allowed}. Replace the geom by one of these."
        )
    world: Triangles = local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
    return world


def _mesh(model: mujoco.MjModel, mesh: int) -> Triangles:
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    return np.asarray(vertices[faces], np.float64)


def _box(size: F64, _slices: int, _stacks: int) -> Triangles:
    low, high = [(-1, -1, 1), (1, -1, 1), (1, 1, 1)], [(-1, -1, 1), (1, 1, 1), (-1, 1, 1)]
    face = np.array([low, high], np.float64)
    faces = [np.roll(face, turn, axis=2) for turn in range(3)]
    return np.concatenate([*faces, *(-side[:, ::-1] for side in faces)]) * size


def _plane(size: F64, slices: int, stacks: int) -> Triangles:
    half = np.where(size[:2] > 0, size[:2], INFINITE_PLANE_HALF_SIDE_M)
    flat: Triangles = _box(np.ones(3), slices, stacks)[:2] * [*half, 0.0]
    return flat


def _ellipsoid(size: F64, slices: int, stacks: int) -> Triangles:
    polar = np.linspace(-np.pi / 2, np.pi / 2, stacks + 2)
    return _revolved(np.cos(polar), np.sin(polar), slices) * size


def _sphere(size: F64, slices: int, stacks: int) -> Triangles:
    return _ellipsoid(np.full(3, size[0]), slices, stacks)


def _cylinder(size: F64, slices: int, _stacks: int) -> Triangles:
    radius, half_length = size[0], size[1]
    return _revolved(
        np.array([0.0, radius, radius, 0.0]),
        np.array([-half_length, -half_length, half_length, half_length]),
        slices,
    )


def _capsule(size: F64, slices: int, stacks: int) -> Triangles:
    radius, half_length = size[0], size[1]
    polar = np.linspace(0, np.pi / 2, stacks + 1)
    cap_radii, cap_heights = radius * np.cos(polar), half_length + radius * np.sin(polar)
    return _revolved(
        np.concatenate([cap_radii[::-1], cap_radii]),
        np.concatenate([-cap_heights[::-1], cap_heights]),
        slices,
    )


def _revolved(radii: F64, heights: F64, slices: int) -> Triangles:
    """Revolve a profile, given from bottom to top, about the z axis."""
    angle = np.arange(slices + 1) * 2 * np.pi / slices
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = np.empty((len(radii), slices + 1, 3))
    points[..., :2] = radii[:, None, None] * ring
    points[..., 2] = heights[:, None]
    a, b = points[:-1, :-1], points[:-1, 1:]
    c, d = points[1:, 1:], points[1:, :-1]
    soup = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)])
    return _without_slivers(soup.reshape(-1, 3, 3))


def _without_slivers(triangles: Triangles) -> Triangles:
    """Drop triangles without area, which a profile that ends on the axis produces."""
    return triangles[np.any(unit_normals(triangles) != 0.0, axis=1)]


_SHAPES: dict[mujoco.mjtGeom, Callable[[F64, int, int], Triangles]] = {
    mujoco.mjtGeom.mjGEOM_PLANE: _plane,
    mujoco.mjtGeom.mjGEOM_SPHERE: _sphere,
    mujoco.mjtGeom.mjGEOM_CAPSULE: _capsule,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: _ellipsoid,
    mujoco.mjtGeom.mjGEOM_CYLINDER: _cylinder,
    mujoco.mjtGeom.mjGEOM_BOX: _box,
}
