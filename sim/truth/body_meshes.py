"""Triangle meshes of a MuJoCo model, one per rigid body, for viewers that cannot read MuJoCo."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from sim.raster.rendered import element_rgba, rendered
from sim.raster.triangles import geom_triangles, unit_normals
from sim.scene.scene import Scene
from sim.scene.srgb import encoded

WORLD = "world"
"""Name of the body to which everything static belongs."""

F64 = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """Triangles of one rigid body in the body's frame. No two triangles share a vertex.

    Attributes:
        name: name of the body; `WORLD` for everything fixed to the world.
        vertices_m: (3n, 3) float32 vertices, three per triangle [m].
        normals: (3n, 3) float32 unit normals, equal for the three vertices of a triangle.
        colours: (3n, 3) uint8 sRGB colours.
    """

    name: str
    vertices_m: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    colours: npt.NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class BodyPose:
    """Pose of a body in the world.

    Attributes:
        position_m: (3,) position of the body's origin [m].
        rotation: (3, 3) rotation matrix; its columns are the body's axes.
    """

    position_m: F64
    rotation: F64


class MovingBodies:
    """The moving rigid bodies of a scene."""

    def __init__(self, scene: Scene) -> None:
        """Find the moving bodies.

        Args:
            scene: the scene, which is not changed.
        """
        self._scene = scene
        self._data = mujoco.MjData(scene.model)
        self._bodies = {
            scene.model.body(k).name: int(k) for k in np.unique(scene.model.body_weldid) if k
        }

    def poses(self, t_s: float) -> dict[str, BodyPose]:
        """Return the pose of each moving body, by its name.

        Args:
            t_s: time since the target's closest approach [s].
        """
        self._scene.place(self._data, t_s)
        return {
            name: BodyPose(self._data.xpos[k].copy(), self._data.xmat[k].reshape(3, 3).copy())
            for name, k in self._bodies.items()
        }


def body_meshes(model: mujoco.MjModel) -> list[BodyMesh]:
    """Return the visible geoms of a model as one mesh per rigid body, the world first.

    Each geom gets a single colour: that of its material, or its own if it has none, times the mean
    of its texture. Colours are taken as linear reflectances.

    Args:
        model: the model.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    body_of_geom = model.body_weldid[model.geom_bodyid]
    texels = [_mean_texel(model, k) for k in range(model.ntex)]
    return [
        _merged(model, data, int(body), np.flatnonzero(body_of_geom == body), texels)
        for body in np.unique(body_of_geom)
    ]


def srgb(linear: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Encode linear colours, 0 to 1, as 8-bit sRGB."""
    return np.asarray(np.rint(encoded(linear) * 255), np.uint8)


def _merged(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    body: int,
    geoms: npt.NDArray[np.int64],
    texels: list[F64],
) -> BodyMesh:
    """Merge the geoms of one body; `texels` holds the mean texel of every texture."""
    visible = [int(k) for k in geoms[rendered(model, "geom")[geoms]]]
    soups = [geom_triangles(model, data, k) for k in visible] or [np.empty((0, 3, 3))]
    colours = [srgb(_linear_colour(model, k, texels)) for k in visible]
    counts = [3 * len(soup) for soup in soups[: len(visible)]]
    triangles = (np.concatenate(soups) - data.xpos[body]) @ data.xmat[body].reshape(3, 3)
    return BodyMesh(
        name=model.body(body).name if body else WORLD,
        vertices_m=triangles.reshape(-1, 3).astype(np.float32),
        normals=np.repeat(unit_normals(triangles), 3, axis=0).astype(np.float32),
        colours=np.repeat(np.array(colours, np.uint8).reshape(-1, 3), counts, axis=0),
    )


def _linear_colour(model: mujoco.MjModel, geom: int, texels: list[F64]) -> F64:
    colour = np.array(element_rgba(model, "geom")[geom, :3], np.float64)
    material = int(model.geom_matid[geom])
    if material < 0:
        return colour
    texture = int(model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB])
    return colour * texels[texture] if texture >= 0 else colour


def _mean_texel(model: mujoco.MjModel, texture: int) -> F64:
    """Mean of a texture's first three channels, or of its single channel, 0 to 1."""
    shape = [int(n[texture]) for n in (model.tex_height, model.tex_width, model.tex_nchannel)]
    start = int(model.tex_adr[texture])
    texels = model.tex_data[start : start + math.prod(shape)].reshape(shape)
    sums = np.array(cv2.sumElems(texels)[: min(shape[2], 3)])
    return sums / (shape[0] * shape[1]) / 255
