"""A MuJoCo model as plain triangles, one mesh a rigid body, for viewers that know no MuJoCo."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.errors import SceneConfigError
from sim.scene import Scene

SEGMENTS = 16
"""Facets around a cylinder, a capsule or an ellipsoid (assumed: round enough to the eye)."""
ENDLESS_M = 50.0
"""Half side that a plane without size is drawn with [m] (assumed)."""
WORLD = "world"
"""Name of the body that never moves."""

F64 = npt.NDArray[np.float64]
Triangles = npt.NDArray[np.float64]
"""(n, 3, 3): triangle, corner, x y z [m]; anticlockwise as seen from outside."""


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """The triangles of one rigid body, in its own frame; each triangle owns its three vertices.

    Attributes:
        name: the body's; `WORLD` for all that is fixed to the world.
        vertices_m: (3n, 3) float32 [m].
        normals: (3n, 3) float32, of unit length; those of a triangle are equal.
        colours: (3n, 3) uint8, sRGB.
    """

    name: str
    vertices_m: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    colours: npt.NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class BodyPose:
    """Where a body is in the world.

    Attributes:
        position_m: (3,) of its origin [m].
        rotation: (3, 3), whose columns are the body's axes.
    """

    position_m: F64
    rotation: F64


class MovingBodies:
    """The bodies of a scene that move with the vehicle."""

    def __init__(self, scene: Scene) -> None:
        """Find them.

        Args:
            scene: stays as it is; the poses are worked out on data of their own.
        """
        self._scene = scene
        self._data = mujoco.MjData(scene.model)
        self._bodies = {
            scene.model.body(k).name: int(k) for k in np.unique(scene.model.body_weldid) if k
        }

    def poses(self, position_m: float) -> dict[str, BodyPose]:
        """World poses by the body's name, with the vehicle at a way along its path [m]."""
        self._scene.place(self._data, position_m)
        return {
            name: BodyPose(self._data.xpos[k].copy(), self._data.xmat[k].reshape(3, 3).copy())
            for name, k in self._bodies.items()
        }


def body_meshes(model: mujoco.MjModel) -> list[BodyMesh]:
    """The visible geoms of a model, merged by rigid body; the world's first.

    A geom has one colour: its material's, or its own, times the mean of its texture. Colours are
    taken as linear reflectances.

    Args:
        model: of boxes, cylinders, capsules, ellipsoids, spheres, meshes and planes.

    Raises:
        SceneConfigError: it has a geom of another type.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    rigid = model.body_weldid[model.geom_bodyid]
    return [
        _merged(model, data, int(body), np.flatnonzero(rigid == body)) for body in np.unique(rigid)
    ]


def srgb(linear: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Encode linear colour, 0 to 1, as sRGB of 8 bits (IEC 61966-2-1)."""
    value = np.clip(np.asarray(linear, np.float64), 0.0, 1.0)
    encoded = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    return np.asarray(np.rint(encoded * 255), np.uint8)


def _merged(
    model: mujoco.MjModel, data: mujoco.MjData, body: int, geoms: npt.NDArray[np.int64]
) -> BodyMesh:
    visible = [int(k) for k in geoms if model.geom_rgba[k, 3] > 0]
    soups = [_geom_triangles(model, data, k) for k in visible] or [np.empty((0, 3, 3))]
    colours = [srgb(_linear_colour(model, k)) for k in visible]
    counts = [3 * len(soup) for soup in soups[: len(visible)]]
    triangles = (np.concatenate(soups) - data.xpos[body]) @ data.xmat[body].reshape(3, 3)
    return BodyMesh(
        name=model.body(body).name if body else WORLD,
        vertices_m=triangles.reshape(-1, 3).astype(np.float32),
        normals=np.repeat(_normals(triangles), 3, axis=0).astype(np.float32),
        colours=np.repeat(np.array(colours, np.uint8).reshape(-1, 3), counts, axis=0),
    )


def _normals(triangles: Triangles) -> F64:
    """(n, 3) unit normals; zero for a triangle without area."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(across, axis=1, keepdims=True)
    normals: F64 = np.divide(across, length, out=np.zeros_like(across), where=length > 0)
    return normals


def _geom_triangles(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Triangles:
    """A geom's triangles in the world."""
    kind = mujoco.mjtGeom(model.geom_type[geom])
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        local = _mesh(model, int(model.geom_dataid[geom]))
    elif kind in _SHAPES:
        local = _SHAPES[kind](model.geom_size[geom])
    else:
        allowed = ", ".join(shape.name for shape in (*_SHAPES, mujoco.mjtGeom.mjGEOM_MESH))
        raise SceneConfigError(
            f"geom {geom} is of type {kind.name}, which has no triangles here; allowed are "
            f"{allowed}; replace it by one of these"
        )
    world: Triangles = local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
    return world


def _linear_colour(model: mujoco.MjModel, geom: int) -> F64:
    material = int(model.geom_matid[geom])
    if material < 0:
        return np.array(model.geom_rgba[geom, :3], np.float64)
    colour = np.array(model.mat_rgba[material, :3], np.float64)
    texture = int(model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB])
    return colour * _mean_texel(model, texture) if texture >= 0 else colour


def _mean_texel(model: mujoco.MjModel, texture: int) -> F64:
    channels = int(model.tex_nchannel[texture])
    start = int(model.tex_adr[texture])
    count = int(model.tex_height[texture]) * int(model.tex_width[texture]) * channels
    texels = model.tex_data[start : start + count].reshape(-1, channels)
    mean: F64 = texels[:, :3].mean(axis=0) / 255
    return mean


def _mesh(model: mujoco.MjModel, mesh: int) -> Triangles:
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    return np.asarray(vertices[faces], np.float64)


def _box(size: F64) -> Triangles:
    low, high = [(-1, -1, 1), (1, -1, 1), (1, 1, 1)], [(-1, -1, 1), (1, 1, 1), (-1, 1, 1)]
    face = np.array([low, high], np.float64)
    faces = [np.roll(face, turn, axis=2) for turn in range(3)]
    return np.concatenate([*faces, *(-side[:, ::-1] for side in faces)]) * size


def _plane(size: F64) -> Triangles:
    half = np.where(size[:2] > 0, size[:2], ENDLESS_M)
    flat: Triangles = _box(np.ones(3))[:2] * [*half, 0.0]
    return flat


def _ellipsoid(size: F64) -> Triangles:
    polar = np.linspace(-np.pi / 2, np.pi / 2, SEGMENTS // 2 + 1)
    return _revolved(np.cos(polar), np.sin(polar)) * size


def _sphere(size: F64) -> Triangles:
    return _ellipsoid(np.full(3, size[0]))


def _cylinder(size: F64) -> Triangles:
    radius, half_length = size[0], size[1]
    return _revolved(
        np.array([0.0, radius, radius, 0.0]),
        np.array([-half_length, -half_length, half_length, half_length]),
    )


def _capsule(size: F64) -> Triangles:
    radius, half_length = size[0], size[1]
    polar = np.linspace(0, np.pi / 2, SEGMENTS // 4 + 1)
    cap_radii, cap_heights = radius * np.cos(polar), half_length + radius * np.sin(polar)
    return _revolved(
        np.concatenate([cap_radii[::-1], cap_radii]),
        np.concatenate([-cap_heights[::-1], cap_heights]),
    )


def _revolved(radii: F64, heights: F64) -> Triangles:
    """Turn a profile, from bottom to top, about the z axis."""
    angle = np.arange(SEGMENTS + 1) * 2 * np.pi / SEGMENTS
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = np.empty((len(radii), SEGMENTS + 1, 3))
    points[..., :2] = radii[:, None, None] * ring
    points[..., 2] = heights[:, None]
    a, b = points[:-1, :-1], points[:-1, 1:]
    c, d = points[1:, 1:], points[1:, :-1]
    soup = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)])
    return _without_slivers(soup.reshape(-1, 3, 3))


def _without_slivers(triangles: Triangles) -> Triangles:
    """Drop those without area, which a profile that ends on the axis makes."""
    return triangles[np.any(_normals(triangles) != 0.0, axis=1)]


_SHAPES: dict[mujoco.mjtGeom, Callable[[F64], Triangles]] = {
    mujoco.mjtGeom.mjGEOM_PLANE: _plane,
    mujoco.mjtGeom.mjGEOM_SPHERE: _sphere,
    mujoco.mjtGeom.mjGEOM_CAPSULE: _capsule,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: _ellipsoid,
    mujoco.mjtGeom.mjGEOM_CYLINDER: _cylinder,
    mujoco.mjtGeom.mjGEOM_BOX: _box,
}
