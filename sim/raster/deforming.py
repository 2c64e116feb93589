"""Triangles of what deforms: flexes, skins, spatial tendons and slider-cranks.

Their facets are those of MuJoCo's abstract visualizer, which the renderer repeats.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from sim.errors import SceneConfigError
from sim.raster.rendered import rendered
from sim.raster.triangles import Triangles, shape_triangles

F64 = npt.NDArray[np.float64]
_OBJ, _GEOM = mujoco.mjtObj, mujoco.mjtGeom

FLEX_QUALITY = 8, 4
"""Slices and stacks with which the renderer renders each edge of a one-dimensional flex."""
MAX_PARTS = 10_000
"""Most parts of tendons that the visualizer lists (assumed)."""


class Deforming(NamedTuple):
    """A flex, skin, tendon or slider-crank.

    Attributes:
        kind: "flex", "skin", "tendon" or "actuator".
        number: number of the element in the model.
        name: its name; empty if it has none.
    """

    kind: str
    number: int
    name: str


class DeformingShapes:
    """Triangles of everything in a model that deforms.

    Attributes:
        objects: what deforms and is rendered.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        """List what deforms.

        Args:
            model: model in which everything that is not rendered has a hidden group.
        """
        self._model = model
        self._scene = mujoco.MjvScene(model, MAX_PARTS)
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = self._option.sitegroup[:] = 0
        self.objects = tuple(
            Deforming(kind, int(k), mujoco.mj_id2name(model, _KINDS[kind], int(k)) or "")
            for kind in _KINDS
            for k in np.flatnonzero(_shown(model, kind))
        )

    def triangles(self, data: mujoco.MjData) -> list[Triangles]:
        """Return the triangles of each of `objects`, in the world [m].

        Args:
            data: with the poses of bodies, flexes and tendons; they are not changed.

        Raises:
            SceneConfigError: tendons have too many parts.
        """
        if not self.objects:
            return []
        every, camera = mujoco.mjtCatBit.mjCAT_ALL, mujoco.MjvCamera()
        mujoco.mjv_updateScene(self._model, data, self._option, None, camera, every, self._scene)
        if self._scene.ngeom >= MAX_PARTS:
            raise SceneConfigError(
                f"the model's tendons have {MAX_PARTS} parts or more. Allowed are fewer. Hide some "
                'of the tendons with group="3".'
            )
        parts: dict[tuple[int, int], list[Triangles]] = {}
        for part in self._scene.geoms[: self._scene.ngeom]:
            if part.type in (_GEOM.mjGEOM_CAPSULE, _GEOM.mjGEOM_CYLINDER):
                shape = self._part(part)
                parts.setdefault((part.objtype, part.objid), []).append(shape)
        return [self._of(item, parts, data) for item in self.objects]

    def _of(
        self, item: Deforming, parts: dict[tuple[int, int], list[Triangles]], data: mujoco.MjData
    ) -> Triangles:
        if item.kind == "skin":
            return self._skin(item.number)
        if item.kind == "flex":
            if self._model.flex_dim[item.number] == 1:
                return self._line(item.number, data)
            return self._flex(item.number)
        own = parts.get((int(_KINDS[item.kind]), item.number), [])
        return np.concatenate([*own, np.empty((0, 3, 3))])

    def _skin(self, skin: int) -> Triangles:
        model, scene = self._model, self._scene
        vertices = scene.skinvert.reshape(-1, 3)[scene.skinvertadr[skin] :]
        faces = model.skin_face[model.skin_faceadr[skin] :][: model.skin_facenum[skin]]
        return np.asarray(vertices[faces], np.float64)

    def _flex(self, flex: int) -> Triangles:
        scene = self._scene
        faces = scene.flexface.reshape(-1, 3, 3)[scene.flexfaceadr[flex] :]
        return np.asarray(faces[: scene.flexfaceused[flex]], np.float64)

    def _line(self, flex: int, data: mujoco.MjData) -> Triangles:
        model, radius_m = self._model, float(self._model.flex_radius[flex])
        points = data.flexvert_xpos[model.flex_vertadr[flex] :]
        edges = model.flex_edge[model.flex_edgeadr[flex] :][: model.flex_edgenum[flex]]
        return np.concatenate([_capsule(points[a], points[b], radius_m) for a, b in edges])

    def _part(self, part: Any) -> Triangles:
        quality = self._model.vis.quality
        size = np.asarray(part.size, np.float64)[[0, 2, 2]]
        local = shape_triangles(_GEOM(part.type), size, quality.numslices, quality.numstacks)
        return np.asarray(local @ np.asarray(part.mat, np.float64).T + part.pos)


_KINDS = {
    "flex": _OBJ.mjOBJ_FLEX,
    "skin": _OBJ.mjOBJ_SKIN,
    "tendon": _OBJ.mjOBJ_TENDON,
    "actuator": _OBJ.mjOBJ_ACTUATOR,
}


def _shown(model: mujoco.MjModel, kind: str) -> npt.NDArray[np.bool_]:
    if kind == "actuator":
        return np.asarray(model.actuator_trntype == mujoco.mjtTrn.mjTRN_SLIDERCRANK)
    shown = rendered(model, kind)
    if kind == "tendon":  # a fixed tendon, which combines joints, has no shape
        shown &= model.wrap_type[model.tendon_adr] != mujoco.mjtWrap.mjWRAP_JOINT
    return shown


def _capsule(start: F64, end: F64, radius_m: float) -> Triangles:
    """Return a capsule between two points in the world, as the renderer turns it [m]."""
    half = (end - start) / 2
    size = np.array([radius_m, np.linalg.norm(half), 0.0])
    turn, quat = np.empty(9), np.empty(4)
    mujoco.mju_quatZ2Vec(quat, half)
    mujoco.mju_quat2Mat(turn, quat)
    local = shape_triangles(_GEOM.mjGEOM_CAPSULE, size, *FLEX_QUALITY)
    return np.asarray(local @ turn.reshape(3, 3).T + (start + end) / 2)
