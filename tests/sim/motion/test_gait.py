import math

import mujoco
import numpy as np
import pytest

from sim import CrossingConfig
from sim.distractors import Distractors, RelativeDirection
from sim.motion.gait import Gait
from sim.scene.facades import PAVEMENT_M
from sim.scene.moving_objects import MovingObject
from sim.scene.scene import Scene, build_scene
from tests.sim.world_triangles import world_points


def walk(speed_m_s: float = 1.4) -> tuple[Scene, MovingObject, mujoco.MjData]:
    extra = Distractors(pedestrian=RelativeDirection.SAME, pedestrian_speed_m_s=speed_m_s)
    scene = build_scene(CrossingConfig(distractors=extra))
    item = next(item for item in scene.objects if item.kind == "pedestrian")
    return scene, item, mujoco.MjData(scene.model)


@pytest.mark.parametrize("speed_m_s", [0.5, 1.4, 2.2])
def test_a_stride_is_two_steps_and_the_walk_ratio_is_kept(speed_m_s: float) -> None:
    gait = Gait(speed_m_s)
    assert gait.stride_s * speed_m_s == pytest.approx(2 * gait.step_m)
    steps_a_minute = 60 * 2 / gait.stride_s
    assert gait.step_m / steps_a_minute == pytest.approx(0.0065)


def test_at_a_usual_speed_the_cadence_is_a_usual_one() -> None:
    assert 100 < 120 / Gait(1.4).stride_s < 125


def test_limbs_come_back_after_a_stride_and_mirror_after_a_step() -> None:
    scene, _, data = walk()
    gait = Gait(1.4)

    def limbs(t_s: float) -> np.ndarray:
        scene.place(data, t_s)
        names = ("hip", "knee", "shoulder", "elbow")
        return np.array(
            [
                [data.joint(f"pedestrian/{name}_{side}").qpos[0] for name in names]
                for side in ("right", "left")
            ]
        )

    np.testing.assert_allclose(limbs(0.2), limbs(0.2 + gait.stride_s), atol=1e-9)
    np.testing.assert_allclose(limbs(0.2), limbs(0.2 + gait.stride_s / 2)[::-1], atol=1e-9)
    assert np.ptp([limbs(t_s)[0, 0] for t_s in np.linspace(0, 1, 50)]) > 0.5


def test_knees_and_elbows_bend_one_way_and_arms_swing_against_legs() -> None:
    gait = Gait(1.4)
    for phase in np.linspace(0, 2 * math.pi, 60):
        hip, knee, _ = gait.leg_rad(phase)
        shoulder, elbow = gait.arm_rad(phase)
        assert 0 < knee < 1.2
        assert 0 < elbow < 1.2
        assert hip * shoulder <= 0


def test_the_foot_in_front_stands_on_the_pavement_and_none_digs_in() -> None:
    scene, _, data = walk()
    model = scene.model
    shoes = [int(model.body(f"pedestrian/foot_{side}").geomadr[0]) for side in ("right", "left")]
    for t_s in np.linspace(0, Gait(1.4).stride_s, 25):
        scene.place(data, t_s)
        lowest = world_points(model, data, shoes)[:, 2].min() - PAVEMENT_M
        assert -0.05 < lowest < 0.05


@pytest.mark.parametrize("speed_m_s", [0.3, 1.4, 2.5])
def test_the_box_holds_the_pedestrian_and_no_point_exceeds_the_bound(
    speed_m_s: float,
) -> None:
    scene, item, data = walk(speed_m_s)
    motion = scene.motions[scene.objects.index(item)]
    step_s = 1e-4
    for t_s in np.linspace(0, Gait(speed_m_s).stride_s, 40):
        scene.place(data, t_s)
        before = world_points(scene.model, data, item.geoms)
        local = (before - data.xpos[item.root]) @ data.xmat[item.root].reshape(3, 3)
        assert (local >= item.box_m[0]).all()
        assert (local <= item.box_m[1]).all()
        scene.place(data, t_s + step_s)
        after = world_points(scene.model, data, item.geoms)
        fastest = np.linalg.norm(after - before, axis=1).max() / step_s
        assert fastest <= motion.fastest_m_s(t_s)
