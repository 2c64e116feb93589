import math

import mujoco
import numpy as np
import pytest

from flybench.direction import Direction
from sim import CrossingConfig
from sim.distractors import Distractors, RelativeDirection, VehicleKind
from sim.motion.paths import Rolling, UniformPath
from sim.scene.scene import Scene, build_scene
from tests.sim.world_triangles import world_points

RADIUS_M = {"sedan": 0.32, "van": 0.34, "motorcycle": 0.31}


def scene_with(kind: str, direction: str = "right") -> Scene:
    return build_scene(CrossingConfig(vehicle=VehicleKind(kind), direction=Direction(direction)))


@pytest.mark.parametrize("direction", ["right", "left"])
@pytest.mark.parametrize("kind", list(VehicleKind))
def test_wheels_turn_as_far_as_they_roll(kind: str, direction: str) -> None:
    """The point of a wheel that touches the road does not move."""
    scene = scene_with(kind, direction)
    motion, data, step_s = scene.motions[0], mujoco.MjData(scene.model), 1e-6
    assert isinstance(motion, Rolling)
    assert set(motion.radii_m) == {RADIUS_M[kind]}
    wheels = [k for k in scene.target.bodies if "wheel" in scene.model.body(k).name]
    assert len(wheels) == (2 if kind == VehicleKind.MOTORCYCLE else 4)
    for wheel in wheels:
        scene.place(data, 0.2)
        middle, turn = data.xpos[wheel].copy(), data.xmat[wheel].reshape(3, 3).copy()
        ground = turn.T @ [0, 0, -middle[2]]
        scene.place(data, 0.2 + step_s)
        after = data.xpos[wheel] + data.xmat[wheel].reshape(3, 3) @ ground
        assert (after - middle)[0] / step_s == pytest.approx(0, abs=1e-3)
        way = scene.trajectory.position_m(0.2 + step_s) - scene.trajectory.position_m(0.2)
        assert data.xpos[wheel][0] - middle[0] == pytest.approx(scene.heading * way)


@pytest.mark.parametrize("kind", list(VehicleKind))
def test_no_visible_mark_moves_faster_than_the_bound(kind: str) -> None:
    scene = scene_with(kind)
    model, motion, data = scene.model, scene.motions[0], mujoco.MjData(scene.model)
    bars = model.geom_type[scene.target.geoms] == mujoco.mjtGeom.mjGEOM_BOX
    marked = scene.target.geoms[bars]
    points, step_s = [], 1e-5
    for t_s in (0.1, 0.1 + step_s):
        scene.place(data, t_s)
        points.append(world_points(model, data, marked))
    fastest = np.linalg.norm(points[1] - points[0], axis=1).max() / step_s
    assert fastest <= motion.fastest_m_s(0.1) * 1.02
    assert fastest > scene.trajectory.speed_m_s(0.1) * 1.3


@pytest.mark.parametrize(
    ("way", "sign"), [(RelativeDirection.SAME, 1), (RelativeDirection.OPPOSITE, -1)]
)
@pytest.mark.parametrize("direction", ["right", "left"])
def test_the_far_vehicle_has_its_direction_and_speed(
    direction: str, way: RelativeDirection, sign: int
) -> None:
    extra = Distractors(far_vehicle=way, far_vehicle_speed_m_s=12.0, far_vehicle_lag_s=0.3)
    scene = build_scene(CrossingConfig(direction=Direction(direction), distractors=extra))
    item, data, x_m = scene.objects[1], mujoco.MjData(scene.model), []
    assert item.name == "far_vehicle"
    for t_s in (0.3, 1.3):
        scene.place(data, t_s)
        x_m.append(float(data.xpos[item.root][0]))
    assert x_m[0] == pytest.approx(0, abs=1e-9)
    assert x_m[1] == pytest.approx(12.0 * sign * scene.heading)


def test_a_uniform_path_is_at_the_origin_when_it_passes() -> None:
    path = UniformPath(5.0, 2.0)
    assert path.position_m(2.0) == 0
    assert path.position_m(3.0) == pytest.approx(5.0)
    assert math.isclose(path.speed_m_s(7.0), 5.0)
