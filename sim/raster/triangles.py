"""The triangles of a MuJoCo model: exactly the facets that the renderer renders."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import mujoco
import numpy as np
import numpy.typing as npt

from sim.raster.height_field import height_field_triangles
from sim.raster.rendered import rendered
from sim.raster.scan_conversion import transform_points

INFINITE_PLANE_HALF_SIDE_M = 100.0
"""Half side of the square that the renderer renders for a plane without a size [m] (measured)."""

F64 = npt.NDArray[np.float64]
Triangles = npt.NDArray[np.float64]
"""(n, 3, 3): triangle, corner, x y z [m]. Corners run anticlockwise as seen from outside."""


@dataclass(frozen=True, eq=False)
class TriangleSoup:
    """All rendered triangles of a model's rigid bodies, each in the frame of its body.

    Attributes:
        triangles_m: (n, 3, 3) float64, in the body's frame [m].
        body: (n,) int32, number of the triangle's rigid body; 0 for what is fixed to the world.
        geom: (n,) int32, number of the triangle's geom; -1 for a site.
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
        points, body = self.triangles_m.reshape(-1, 3), np.repeat(self.body, 3)
        return np.asarray(transform_points(points, body, transforms)).reshape(-1, 3, 3)


def triangle_soup(model: mujoco.MjModel, *, complete: bool = False) -> TriangleSoup:
    """Return the rendered geoms of a model as triangles.

    Args:
        model: the model.
        complete: True to add the rendered sites, and the backs of planes. A camera that is below a
            plane sees its back.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    geoms = _soup_of(model, data, "geom")
    if not complete:
        return geoms
    is_plane = model.geom_type[geoms.geom] == mujoco.mjtGeom.mjGEOM_PLANE
    backs = geoms.subset(np.asarray(is_plane))
    soups = (geoms, _soup_of(model, data, "site"), backs)
    return TriangleSoup(
        np.concatenate([*(s.triangles_m for s in soups[:2]), backs.triangles_m[:, ::-1]]),
        np.concatenate([soup.body for soup in soups]),
        np.concatenate([soup.geom for soup in soups]),
    )


def _soup_of(model: mujoco.MjModel, data: mujoco.MjData, kind: str) -> TriangleSoup:
    """Return the rendered elements of one kind, "geom" or "site"."""
    rigid = model.body_weldid[getattr(model, f"{kind}_bodyid")]
    numbers = np.flatnonzero(rendered(model, kind))
    pieces = [_in_body_frame(model, data, kind, int(k), int(rigid[k])) for k in numbers]
    counts = [len(triangles) for triangles in pieces]
    geoms = numbers if kind == "geom" else np.full(len(numbers), -1)
    return TriangleSoup(
        np.concatenate([*pieces, np.empty((0, 3, 3))]),
        np.repeat(rigid[numbers], counts).astype(np.int32),
        np.repeat(geoms, counts).astype(np.int32),
    )


def _in_body_frame(
    model: mujoco.MjModel, data: mujoco.MjData, kind: str, number: int, body: int
) -> Triangles:
    world = element_triangles(model, data, kind, number)
    return np.asarray((world - data.xpos[body]) @ data.xmat[body].reshape(3, 3))


def unit_normals(triangles: Triangles) -> F64:
    """Return the unit normals, (n, 3). The normal of a triangle without area is zero."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(across, axis=1, keepdims=True)
    normals: F64 = np.divide(across, length, out=np.zeros_like(across), where=length > 0)
    return normals


def geom_triangles(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Triangles:
    """Return a geom's triangles in the world frame."""
    return element_triangles(model, data, "geom", geom)


def element_triangles(
    model: mujoco.MjModel, data: mujoco.MjData, kind: str, number: int
) -> Triangles:
    """Return the triangles of a geom or a site in the world frame.

    Args:
        model: the model.
        data: its poses.
        kind: "geom" or "site".
        number: number of the element.
    """

    def of(array: str, source: mujoco.MjModel | mujoco.MjData = model) -> npt.NDArray[np.float64]:
        return np.asarray(getattr(source, f"{kind}_{array}")[number])

    shape, quality = mujoco.mjtGeom(of("type")), model.vis.quality
    if shape in _MESHES:
        local = _mesh(model, int(of("dataid")), in_own_frame=kind == "site")
    elif shape == mujoco.mjtGeom.mjGEOM_HFIELD:
        local = height_field_triangles(model, int(of("dataid")))
    else:
        local = shape_triangles(shape, of("size"), quality.numslices, quality.numstacks)
    return np.asarray(local @ of("xmat", data).reshape(3, 3).T + of("xpos", data))


def shape_triangles(shape: mujoco.mjtGeom, size: F64, slices: int, stacks: int) -> Triangles:
    """Return the facets of a plane, sphere, capsule, ellipsoid, cylinder or box in its own frame.

    Args:
        shape: type of the shape.
        size: (3,) size as in MuJoCo's geoms [m].
        slices: number of facets around its axis.
        stacks: number of rings of facets of a sphere, or of each end of a capsule.
    """
    return _SHAPES[shape](size, slices, stacks)


def _mesh(model: mujoco.MjModel, mesh: int, *, in_own_frame: bool) -> Triangles:
    """Return a mesh in the frame of its inertia, or in the frame that its file has."""
    vertices = np.asarray(
        model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]], np.float64
    )
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    if in_own_frame:
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, model.mesh_quat[mesh])
        vertices = vertices @ turn.reshape(3, 3).T + model.mesh_pos[mesh]
    return np.asarray(vertices[faces])


@cache
def _unit_box() -> Triangles:
    low, high = [(-1, -1, 1), (1, -1, 1), (1, 1, 1)], [(-1, -1, 1), (1, 1, 1), (-1, 1, 1)]
    face = np.array([low, high], np.float64)
    faces = [np.roll(face, turn, axis=2) for turn in range(3)]
    return np.concatenate([*faces, *(-side[:, ::-1] for side in faces)])


def _box(size: F64, _slices: int, _stacks: int) -> Triangles:
    return np.asarray(_unit_box() * size)


def _plane(size: F64, slices: int, stacks: int) -> Triangles:
    infinite = np.any(size[:2] <= 0)
    half = np.full(2, INFINITE_PLANE_HALF_SIDE_M) if infinite else size[:2]
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


_MESHES = (mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_SDF)
_SHAPES: dict[mujoco.mjtGeom, Callable[[F64, int, int], Triangles]] = {
    mujoco.mjtGeom.mjGEOM_PLANE: _plane,
    mujoco.mjtGeom.mjGEOM_SPHERE: _sphere,
    mujoco.mjtGeom.mjGEOM_CAPSULE: _capsule,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: _ellipsoid,
    mujoco.mjtGeom.mjGEOM_CYLINDER: _cylinder,
    mujoco.mjtGeom.mjGEOM_BOX: _box,
}
