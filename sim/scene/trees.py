"""Trees: a fixed trunk, and a crown of boughs that sways in the wind.

Shapes are drawn at random. Sizes and probabilities are assumed unless a source is given.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.motion.band_limited_noise import BandLimitedNoise, band_limited_noise

BOUGHS = 4
"""Number of rigid boughs in a crown (by eye)."""
LEAVES = 56
"""Number of leaf tufts on a bough, two triangles each (by eye)."""
CORE_POINTS = 14
"""Number of points whose hull stands for the twigs and shaded leaves in a bough (by eye)."""
LEAF_M = (0.13, 0.27)
"""Smallest and largest half length of a tuft [m] (by eye)."""
CROWN_SWAY_DEG, BOUGH_SWAY_DEG = 0.06, 0.12
"""Root mean square sway angle at Beaufort 1 [deg] (assumed; 2.2° and 4.3° at Beaufort 6). It grows
with the square of the grade: leaves fold, so drag grows with wind speed to the power 1.3 (Vogel
1989), and wind speed grows with the grade to the power 1.5."""
CROWN_SWAY_HZ, BOUGH_SWAY_HZ = 0.6, 1.6
"""Corner frequencies of the sway [Hz] (assumed; street trees swing at 0.3 to 1 Hz)."""
_TUFT = np.array([(-0.9, -0.35), (0.3, -1.0), (1.0, 0.4), (-0.2, 0.9)])
"""Outline of a tuft, in units of its half length (by eye)."""
_TUFT_UV = np.array([(0.0, 0.0), (0.3, 0.0), (0.3, 0.3), (0.0, 0.3)])
"""Section of the foliage texture that one tuft shows."""
_SWAY_STREAM, _TONES = 2, 8
"""Random stream of the wind, distinct from that of the camera shake with the same seed; and number
of sinusoids in each sway (assumed)."""

F64 = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Tree:
    """One tree.

    Attributes:
        name: name of the body of its crown, such as "tree_0".
        x_m: position along the road [m].
        y_m: position across the road, away from the camera [m].
        trunk_m: height of the trunk below the crown [m].
        crown_m: radius of the crown [m].
        height_m: height of the crown [m].
        seed: seed of its shape.
    """

    name: str
    x_m: float
    y_m: float
    trunk_m: float
    crown_m: float
    height_m: float
    seed: int


def add_tree(spec: mujoco.MjSpec, tree: Tree, *, sways: bool) -> None:
    """Add a tree to the street.

    Args:
        spec: model with the materials "bark", "foliage" and "foliage_core".
        tree: the tree.
        sways: True if its crown and boughs have joints.
    """
    rng = np.random.default_rng([tree.seed])
    radius = 0.05 + 0.055 * tree.crown_m
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius, tree.trunk_m / 2 + 0.15, 0],
        pos=[tree.x_m, tree.y_m, tree.trunk_m / 2 + 0.15],
        material="bark",
    )
    crown = spec.worldbody.add_body(name=tree.name, pos=[tree.x_m, tree.y_m, tree.trunk_m])
    if sways:
        crown.mass, crown.inertia, crown.explicitinertial = 1.0, [1.0, 1.0, 1.0], True
        _hinge(crown, tree.name)
    for k in range(BOUGHS):
        _add_bough(spec, crown, tree, k, rng, sways=sways)


@dataclass(frozen=True, eq=False)
class Swaying:
    """Motion of a tree: the angle of every hinge is band-limited noise.

    Attributes:
        hinges: (n,) `qpos` addresses of two hinges of the crown, then two of each bough.
        angles: angle of each hinge over time [rad].
        reach_m: distance from a hinge to the farthest leaf [m].
    """

    hinges: npt.NDArray[np.int64]
    angles: tuple[BandLimitedNoise, ...]
    reach_m: float

    def place(self, qpos: F64, t_s: float) -> None:
        """Set the hinges for a time [s]."""
        qpos[self.hinges] = [one.value(t_s) for one in self.angles]

    def fastest_m_s(self, t_s: float) -> float:
        """Return a bound on the speed of any leaf [m/s]: bough and crown turn the same way."""
        rates = np.array([one.rate(t_s) for one in self.angles]).reshape(-1, 2)
        crown, *boughs = np.linalg.norm(rates, axis=1)
        return self.reach_m * float(crown + max(boughs))

    @property
    def excursion_m(self) -> float:
        """Largest distance of any leaf from its rest position [m]: all tones peak at once."""
        most = np.array([one.amplitude * len(one.phase_rad) for one in self.angles])
        crown, *boughs = np.linalg.norm(most.reshape(-1, 2), axis=1)
        return self.reach_m * float(crown + max(boughs))


def swaying(model: mujoco.MjModel, tree: Tree, grade: int, rng: np.random.Generator) -> Swaying:
    """Return the motion of a tree with hinges in wind of a Beaufort grade."""
    joints = [model.joint(k) for k in range(model.njnt)]
    mine = [joint for joint in joints if joint.name.startswith(f"{tree.name}_sway")]
    boughs = [joint for joint in joints if joint.name.startswith(f"{tree.name}_bough")]
    strength = np.radians(grade**2)
    crown_rad, bough_rad = strength * CROWN_SWAY_DEG, strength * BOUGH_SWAY_DEG
    angles = [
        band_limited_noise(rng, rms=crown_rad, corner_hz=CROWN_SWAY_HZ, tones=_TONES) for _ in mine
    ]
    angles += [
        band_limited_noise(rng, rms=bough_rad, corner_hz=BOUGH_SWAY_HZ, tones=_TONES)
        for _ in boughs
    ]
    return Swaying(
        hinges=np.array([joint.qposadr[0] for joint in mine + boughs], np.int64),
        angles=tuple(angles),
        reach_m=tree.height_m + tree.crown_m,
    )


def sway_rng(seed: int) -> np.random.Generator:
    """Return the random generator of the wind, distinct from that of the camera shake."""
    return np.random.default_rng([seed, _SWAY_STREAM])


def _hinge(body: mujoco.MjsBody, name: str) -> None:
    for axis, vector in (("x", [1, 0, 0]), ("y", [0, 1, 0])):
        body.add_joint(
            name=f"{name}_sway_{axis}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=vector, armature=1
        )


def _add_bough(
    spec: mujoco.MjSpec,
    crown: mujoco.MjsBody,
    tree: Tree,
    number: int,
    rng: np.random.Generator,
    *,
    sways: bool,
) -> None:
    """Add a bough: a branch, a dark core of twigs, and tufts of leaves around it."""
    name = f"{tree.name}_bough_{number}"
    middle, radii = _bough_shape(tree, number, rng)
    start = np.array([0, 0, 0.25 * tree.height_m])
    body = crown.add_body(name=name, pos=start)
    if sways:
        _hinge(body, name)
    reach = middle - start
    core = spec.add_mesh(name=f"{name}_core", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    core.uservert = (_on_sphere(rng, CORE_POINTS) * radii * 0.78 + reach).ravel()
    leaves = spec.add_mesh(
        name=f"{name}_leaves", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    )
    leaves.uservert, leaves.usertexcoord, leaves.userface = _leaves(rng, reach, radii)
    for mesh, material in ((core, "foliage_core"), (leaves, "foliage")):
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, material=material, mass=1
        )
    branch = np.concatenate([np.array([0, 0, -0.3 * tree.height_m]), reach * 0.8])
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        fromto=branch,
        size=[0.04, 0.04, 0],
        material="bark",
        mass=1,
        castshadow=False,
    )


def _bough_shape(tree: Tree, number: int, rng: np.random.Generator) -> tuple[F64, F64]:
    """Draw the centre of a bough in the frame of the crown, and its half axes [m]."""
    low, level = tree.height_m * 0.42, number < BOUGHS - 1
    turn = 2 * np.pi * (number / (BOUGHS - 1) + rng.uniform(-0.1, 0.1))
    out = tree.crown_m * rng.uniform(0.4, 0.55) * level
    rise = low + (0 if level else tree.height_m * 0.3) + rng.normal(0, 0.08) * tree.height_m
    middle = np.array([out * np.cos(turn), out * np.sin(turn), rise])
    radii = tree.crown_m * rng.uniform(0.5, 0.66, 3) * [1, 1, 0.55 * tree.height_m / tree.crown_m]
    return middle, radii


def _leaves(rng: np.random.Generator, middle: F64, radii: F64) -> tuple[F64, F64, F64]:
    """Draw the tufts of a bough: corners, texture coordinates and triangles, each flattened.

    A tuft is visible from one side only, so most face the camera.
    """
    outward = _on_sphere(rng, LEAVES)
    seen = rng.uniform(size=LEAVES) < 0.8
    outward[seen, 1] = -np.abs(outward[seen, 1])
    normal = outward + 0.5 * rng.standard_normal((LEAVES, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    across = np.cross(normal, rng.standard_normal((LEAVES, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    along = np.cross(normal, across)
    centre = middle + outward * radii * rng.uniform(0.72, 1.05, (LEAVES, 1))
    size = rng.uniform(*LEAF_M, (LEAVES, 1, 1))
    sides = np.stack([across, along], axis=1)
    corners = centre[:, None] + size * np.einsum("ck,nkd->ncd", _TUFT, sides)
    uv = rng.uniform(0, 1, (LEAVES, 1, 2)) + _TUFT_UV
    first = 4 * np.arange(LEAVES)[:, None, None]
    faces = first + np.array([[0, 1, 2], [0, 2, 3]])
    return corners.ravel(), uv.ravel(), faces.ravel()


def _on_sphere(rng: np.random.Generator, count: int) -> F64:
    points = rng.standard_normal((count, 3))
    return np.asarray(points / np.linalg.norm(points, axis=1, keepdims=True))
