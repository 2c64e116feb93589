"""Triangle meshes and poses of a scene's rigid bodies."""

import mujoco
import numpy as np
import pytest

from flybench.direction import Direction
from sim import CrossingConfig
from sim.scene.scene import build_scene
from sim.truth.body_meshes import WORLD, BodyMesh, MovingBodies, body_meshes, srgb


def model_of(geom: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{geom}</worldbody></mujoco>")


def only_mesh(geom: str) -> BodyMesh:
    (mesh,) = body_meshes(model_of(geom))
    return mesh


def volume_m3(mesh: BodyMesh) -> float:
    """Volume by the divergence theorem; positive only if the triangles face outwards."""
    a, b, c = mesh.vertices_m.astype(np.float64).reshape(-1, 3, 3).transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


@pytest.mark.parametrize(
    ("geom", "expected_m3"),
    [
        ('<geom type="box" size="1 2 3"/>', 48.0),
        ('<geom type="box" size="1 2 3" pos="5 6 7" euler="10 20 30"/>', 48.0),
        ('<geom type="sphere" size="2"/>', 4 / 3 * np.pi * 8),
        ('<geom type="ellipsoid" size="1 2 3"/>', 4 / 3 * np.pi * 6),
        ('<geom type="cylinder" size="1 2"/>', np.pi * 4),
        ('<geom type="capsule" size="1 2"/>', np.pi * (4 + 4 / 3)),
    ],
)
def test_closed_shapes_have_their_volume_and_face_outwards(geom: str, expected_m3: float) -> None:
    assert volume_m3(only_mesh(geom)) == pytest.approx(expected_m3, rel=0.08)


def test_the_corners_of_a_box_are_at_the_pose_of_the_geom() -> None:
    mesh = only_mesh('<geom type="box" size="1 2 3" pos="5 0 0"/>')
    assert mesh.name == WORLD
    np.testing.assert_allclose(mesh.vertices_m.min(axis=0), [4, -2, -3], atol=1e-6)
    np.testing.assert_allclose(mesh.vertices_m.max(axis=0), [6, 2, 3], atol=1e-6)


def test_normals_have_unit_length_and_point_out_of_a_convex_body() -> None:
    mesh = only_mesh('<geom type="capsule" size=".5 1"/>')
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-6)
    assert np.all(np.einsum("ij,ij->i", mesh.normals, mesh.vertices_m) > 0)


def test_an_infinite_plane_is_horizontal_and_faces_up() -> None:
    mesh = only_mesh('<geom type="plane" size="0 0 1"/>')
    assert np.all(mesh.vertices_m[:, 2] == 0)
    np.testing.assert_array_equal(mesh.normals, np.tile([0, 0, 1], (6, 1)))


def test_colours_are_encoded_as_srgb() -> None:
    mesh = only_mesh('<geom type="box" size="1 1 1" rgba="1 .2158605 0 1"/>')
    np.testing.assert_array_equal(np.unique(mesh.colours, axis=0), [[255, 128, 0]])


def test_a_textured_geom_has_the_mean_colour_of_its_texture() -> None:
    texture = (
        '<texture name="t" type="2d" builtin="flat" rgb1="1 .2 0" mark="edge" markrgb="0 1 .4" '
        'width="3" height="3"/><material name="m" texture="t" rgba=".5 1 1 1"/>'
    )
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><asset>{texture}</asset>"
        '<worldbody><geom type="box" size="1 1 1" material="m"/></worldbody></mujoco>'
    )
    texels = model.tex_data.reshape(-1, 3)
    assert len(np.unique(texels, axis=0)) == 2
    (mesh,) = body_meshes(model)
    expected = srgb(texels.mean(axis=0) / 255 * [0.5, 1, 1])
    np.testing.assert_array_equal(np.unique(mesh.colours, axis=0), [expected])


def test_srgb_encoding_maps_black_and_white_and_increases_between() -> None:
    ramp = srgb(np.linspace(0, 1, 50)).astype(int)
    assert ramp[0] == 0
    assert ramp[-1] == 255
    assert np.all(np.diff(ramp) > 0)


def test_an_invisible_geom_has_no_triangles() -> None:
    assert only_mesh('<geom type="box" size="1 1 1" rgba="1 1 1 0"/>').vertices_m.shape == (0, 3)


def test_the_street_is_static_and_the_vehicle_has_five_moving_bodies() -> None:
    scene = build_scene(CrossingConfig())
    meshes = {mesh.name: mesh for mesh in body_meshes(scene.model)}
    moving = set(MovingBodies(scene).poses(0.0))
    assert len(moving) == 5
    assert set(meshes) == {WORLD, *moving}
    low, high = scene.target.box_m
    body = meshes["vehicle/sedan"].vertices_m
    assert np.all((body >= low - 0.05) & (body <= high + 0.05))


@pytest.mark.parametrize("direction", [Direction.RIGHT, Direction.LEFT])
def test_bodies_move_with_the_vehicle(direction: Direction) -> None:
    scene = build_scene(CrossingConfig(direction=direction))
    bodies = MovingBodies(scene)
    before, after = bodies.poses(0.0), bodies.poses(scene.trajectory.time_at_s(2.0))
    for name, pose in after.items():
        moved = pose.position_m - before[name].position_m
        np.testing.assert_allclose(moved, [2.0 * scene.heading, 0, 0], atol=1e-9)


def test_a_wheel_rolls_without_slipping() -> None:
    scene = build_scene(CrossingConfig())
    bodies = MovingBodies(scene)
    quarter_s = scene.trajectory.time_at_s(0.32 * np.pi / 2)
    before, after = (bodies.poses(t_s)["vehicle/wheel_front_left"] for t_s in (0.0, quarter_s))
    turned = after.rotation @ before.rotation.T
    np.testing.assert_allclose(turned @ [0, 0, 1], [1, 0, 0], atol=1e-9)
