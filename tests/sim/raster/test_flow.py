"""Depth and flow, compared with closed forms."""

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.motion.camera_shake import rotation
from sim.raster.flow import depth_m, displacement_px, flow_px_s, transforms_between, twists_between
from sim.raster.triangles import triangle_soup
from sim.raster.visibility import visibility_map

F64 = npt.NDArray[np.float64]
LENS = Intrinsics(width=64, height=48, focal_px=60.0)
EYE = Pose(np.zeros(3))  # looks along y; x is right, and z up
WALL = """
<mujoco><worldbody><body name="wall" pos="0 4 0">
  <joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
  <joint name="z" type="slide" axis="0 0 1"/><geom type="box" size="{half} .5 {half}" mass="1"/>
</body></worldbody></mujoco>"""
SPEED_M_S = np.array([1.5, -2.0, 0.7])


def rays() -> tuple[F64, F64]:
    """Return the slopes of the rays through the pixel centres, to the right and down."""
    x = (np.arange(LENS.width) + 0.5 - LENS.width / 2) / LENS.focal_px
    y = (np.arange(LENS.height) + 0.5 - LENS.height / 2) / LENS.focal_px
    right, down = np.meshgrid(x, y)
    return right, down


def wall_views(model: mujoco.MjModel, t_s: float, pose: Pose = EYE) -> F64:
    data = mujoco.MjData(model)
    data.qpos[:] = SPEED_M_S * t_s
    mujoco.mj_kinematics(model, data)
    return compose_transforms(body_poses(data), pose.world_to_camera)


def wall_flow(half_m: float, step_s: float = 1e-5) -> tuple[npt.NDArray[np.float32], F64]:
    model = mujoco.MjModel.from_xml_string(WALL.format(half=half_m))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    visible = visibility_map(triangle_soup(model), body_poses(data), EYE, LENS)
    views = [wall_views(model, t) for t in (-step_s, 0.0, step_s)]
    twists = twists_between(views[0], views[1], views[2], 2 * step_s)
    return flow_px_s(visible, twists, LENS), depth_m(visible).astype(np.float64)


def test_the_flow_of_a_moving_wall_is_f_v_over_z() -> None:
    """The flow is u̇ = f/Z·(v_x − x·v_z), v̇ = f/Z·(v_y − y·v_z)."""
    flow, depth = wall_flow(half_m=20.0)
    x, y = rays()
    assert depth == pytest.approx(3.5, rel=1e-6)
    across, along, up = SPEED_M_S
    assert flow[..., 0] == pytest.approx(60 / 3.5 * (across - x * along), rel=1e-5)
    assert flow[..., 1] == pytest.approx(60 / 3.5 * (-up - y * along), rel=1e-5)


def test_sky_has_infinite_depth_and_no_flow() -> None:
    flow, depth = wall_flow(half_m=0.5)
    assert np.isinf(depth).any()
    assert np.isfinite(depth).any()
    assert np.array_equal(np.isinf(depth), (flow == 0).all(axis=-1))


def test_the_displacement_of_a_wall_leads_to_its_later_projection() -> None:
    model = mujoco.MjModel.from_xml_string(WALL.format(half=20.0))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    visible = visibility_map(triangle_soup(model), body_poses(data), EYE, LENS)
    transforms = transforms_between(wall_views(model, 0.0), wall_views(model, 0.5))
    found = displacement_px(visible, transforms, LENS)
    x, y = rays()
    nearer = 3.5 - 1.0
    assert found[..., 0] == pytest.approx(60 * ((3.5 * x + 0.75) / nearer - x), abs=1e-3)
    assert found[..., 1] == pytest.approx(60 * ((3.5 * y - 0.35) / nearer - y), abs=1e-3)
    behind_camera = displacement_px(
        visible, transforms_between(wall_views(model, 0.0), wall_views(model, 2.0)), LENS
    )
    assert np.isnan(behind_camera).all()


def test_camera_rotation_gives_rotational_flow_at_any_depth() -> None:
    """u̇ = f·(−ω_y + ω_z·y + ω_x·x·y − ω_y·x²), v̇ = f·(ω_x − ω_z·x + ω_x·y² − ω_y·x·y)."""
    omega = np.array([0.3, -0.8, 1.1])  # about right, down and forward
    model = mujoco.MjModel.from_xml_string(WALL.format(half=0.5))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)

    def turned(t_s: float) -> Pose:
        frame = np.stack([EYE.right, -EYE.up, EYE.forward], axis=1) @ rotation(omega * t_s)
        return Pose(EYE.position_m, frame[:, 0], -frame[:, 1])

    poses, step_s = body_poses(data), 1e-5
    views = [compose_transforms(poses, turned(t).world_to_camera) for t in (-step_s, 0.0, step_s)]
    visible = visibility_map(triangle_soup(model), poses, EYE, LENS)
    assert len(np.unique(visible.body)) == 2
    twists = twists_between(views[0], views[1], views[2], 2 * step_s)
    flow = flow_px_s(visible, twists, LENS)
    (x, y), (a, b, c) = rays(), omega
    assert flow[..., 0] == pytest.approx(60 * (-b + c * y + a * x * y - b * x * x), abs=1e-4)
    assert flow[..., 1] == pytest.approx(60 * (a - c * x + a * y * y - b * x * y), abs=1e-4)
