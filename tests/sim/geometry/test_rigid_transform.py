"""Rigid transforms against 4 × 4 matrices and the projection of the camera."""

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Intrinsics, Pose, project
from sim.geometry.rigid_transform import (
    axes_along,
    body_poses,
    chain,
    compose_transforms,
    inverse_transform,
)

F64 = npt.NDArray[np.float64]


def random_transforms(count: int, seed: int) -> F64:
    random = np.random.default_rng(seed)
    turns = np.linalg.qr(random.normal(size=(count, 3, 3)))[0]
    return np.concatenate([turns, random.normal(size=(count, 3, 1))], axis=2)


def square(moves: F64) -> F64:
    """(n, 4, 4)."""
    last = np.broadcast_to([[0.0, 0.0, 0.0, 1.0]], (len(moves), 1, 4))
    return np.concatenate([moves, last], axis=1)


def test_composed_transforms_are_the_matrix_product() -> None:
    before, after = random_transforms(5, 0), random_transforms(5, 1)
    wanted = square(after) @ square(before)
    np.testing.assert_allclose(compose_transforms(before, after), wanted[:, :3], atol=1e-12)
    np.testing.assert_allclose(
        compose_transforms(before, after[0]),
        (square(after[:1]) @ square(before))[:, :3],
        atol=1e-12,
    )


def test_a_transform_and_its_inverse_cancel() -> None:
    moves = random_transforms(5, 2)
    nowhere = np.broadcast_to(np.eye(3, 4), moves.shape)
    np.testing.assert_allclose(
        compose_transforms(moves, inverse_transform(moves)), nowhere, atol=1e-12
    )
    np.testing.assert_allclose(
        compose_transforms(inverse_transform(moves), moves), nowhere, atol=1e-12
    )
    np.testing.assert_allclose(inverse_transform(moves)[3], inverse_transform(moves[3]))


DIRECTIONS = [*np.random.default_rng(3).normal(size=(8, 3)), *np.eye(3), *-np.eye(3)]


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_axes_look_along_their_direction(direction: F64) -> None:
    forward = direction / np.linalg.norm(direction)
    axes = axes_along(forward)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1)  # right × down is forward
    np.testing.assert_allclose(axes[2], forward)
    if abs(forward[2]) < 0.9:
        assert axes[0, 2] == 0
        assert axes[1, 2] < 0


def test_a_chain_is_the_composition_of_two_transforms() -> None:
    first, then = random_transforms(2, seed=5)
    out = np.empty((3, 4))
    chain(first, then, out)
    np.testing.assert_allclose(out, compose_transforms(first, then))


def test_in_the_cameras_frame_points_are_where_it_projects_them() -> None:
    lens, pose = Intrinsics(), Pose(np.array([1.0, -7.0, 1.2])).rolled(0.3)
    points = np.random.default_rng(4).uniform(-2, 2, (20, 3))
    x, y, z = pose.world_to_camera @ np.column_stack([points, np.ones(20)]).T
    pixels, depth = project(points, pose, lens)
    np.testing.assert_allclose(z, depth)
    np.testing.assert_allclose(lens.width / 2 + lens.focal_px * x / z, pixels[:, 0])
    np.testing.assert_allclose(lens.height / 2 + lens.focal_px * y / z, pixels[:, 1])


def test_body_poses_take_a_bodys_points_into_the_world() -> None:
    model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody>
      <body pos="1 2 3" euler="10 20 30"><geom size=".1" pos=".4 .5 .6"/></body>
    </worldbody></mujoco>""")
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    poses = body_poses(data)
    np.testing.assert_allclose(poses[0], np.eye(3, 4))
    np.testing.assert_allclose(poses[1] @ [0.4, 0.5, 0.6, 1], data.geom_xpos[0])
