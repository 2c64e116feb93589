"""Find faces that share a plane, which renderers may draw in any order."""

import itertools

import mujoco
import numpy as np
import numpy.typing as npt

from sim.raster.triangles import geom_triangles

F64 = npt.NDArray[np.float64]
FINE_M, OVERLAP_M = 2e-4, 2e-3


def shared_planes(
    model: mujoco.MjModel, *, within_m: float = np.inf, eye_m: F64 | None = None
) -> set[tuple[str, str]]:
    """Return materials whose faces lie in one plane, face the same way and overlap.

    Faces that look down, away from `eye_m`, or beyond `within_m` along the world's x, are left out.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    pieces = [geom_triangles(model, data, k) for k in range(model.ngeom)]
    triangles = np.concatenate(pieces)
    geom = np.repeat(np.arange(model.ngeom), [len(piece) for piece in pieces])
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.linalg.norm(normals, axis=1)
    seen = (area > 1e-10) & (normals[:, 2] > -0.5 * area)
    seen &= (np.abs(triangles[..., 0]) < within_m).any(axis=1)
    if eye_m is not None:
        seen &= np.einsum("ij,ij->i", normals, eye_m - triangles[:, 0]) > 0
    triangles, geoms, normals = triangles[seen], geom[seen], normals[seen]
    normals /= area[seen, None]
    offset = np.einsum("ij,ij->i", normals, triangles[:, 0])
    key = np.round(np.column_stack([normals * 500, offset / FINE_M])).astype(int)
    _, plane = np.unique(key, axis=0, return_inverse=True)
    order = np.argsort(plane.ravel(), kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(plane.ravel()[order])) + 1)
    found = set()
    for group in groups:
        for a, b in itertools.combinations(group, 2):
            first, second = (int(model.geom_matid[geoms[k]]) for k in (a, b))
            if first != second and _overlap(triangles[a], triangles[b], normals[a]):
                found.add((model.mat(first).name, model.mat(second).name))
    return found


def _overlap(first: F64, second: F64, normal: F64) -> bool:
    """Return True if two coplanar triangles overlap: no edge separates them."""
    for one, other in ((first, second), (second, first)):
        for k in range(3):
            across = np.cross(one[(k + 1) % 3] - one[k], normal)
            across /= np.linalg.norm(across)
            if np.min((other - one[k]) @ across) > -OVERLAP_M:
                return False
    return True
