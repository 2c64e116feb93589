import mujoco
import numpy as np
import pytest

from sim import CrossingConfig
from sim.distractors import Distractors
from sim.scene.scene import Scene, build_scene
from sim.scene.trees import BOUGH_SWAY_DEG, CROWN_SWAY_DEG, Swaying
from tests.sim.world_triangles import world_points, world_triangles


def windy(grade: int, seed: int = 0) -> Scene:
    return build_scene(CrossingConfig(distractors=Distractors(wind_grade=grade, seed=seed)))


def test_trees_move_only_in_the_wind() -> None:
    assert not any(item.kind == "tree" for item in build_scene(CrossingConfig()).objects)
    trees = [item for item in windy(3).objects if item.kind == "tree"]
    assert len(trees) >= 2
    assert [tree.name for tree in trees] == [f"tree_{k}" for k in range(len(trees))]


def test_calm_and_windy_trees_have_the_same_leaves() -> None:
    calm, swaying = build_scene(CrossingConfig()).model, windy(3).model
    np.testing.assert_array_equal(calm.mesh_vert, swaying.mesh_vert)


def test_sway_has_the_angles_of_its_grade() -> None:
    scene = windy(6)
    motion = next(motion for motion in scene.motions if isinstance(motion, Swaying))
    qpos, seen = np.zeros(scene.model.nq), []
    for t_s in np.arange(0, 300, 0.037):
        motion.place(qpos, t_s)
        seen.append(np.degrees(qpos[motion.hinges]))
    rms = np.sqrt(np.mean(np.square(seen), axis=0))
    assert rms[:2] == pytest.approx([36 * CROWN_SWAY_DEG] * 2, rel=0.1)
    assert rms[2:] == pytest.approx([36 * BOUGH_SWAY_DEG] * (len(rms) - 2), rel=0.1)


def test_a_seed_gives_the_same_wind_and_another_seed_another() -> None:
    def hinges(seed: int) -> np.ndarray:
        scene = windy(5, seed)
        data = mujoco.MjData(scene.model)
        scene.place(data, 0.7)
        return np.array(data.qpos)

    np.testing.assert_array_equal(hinges(1), hinges(1))
    assert not np.array_equal(hinges(1), hinges(2))


@pytest.mark.parametrize("grade", [2, 8])
def test_the_box_holds_every_leaf_and_none_is_faster_than_the_bound(grade: int) -> None:
    scene = windy(grade)
    data, step_s = mujoco.MjData(scene.model), 1e-4
    for item, motion in zip(scene.objects, scene.motions, strict=True):
        if item.kind != "tree":
            continue
        scene.place(data, 0.0)
        assert len(world_triangles(scene.model, data, item.geoms)) <= 600
        for t_s in np.linspace(0, 4, 15):
            scene.place(data, t_s)
            before = world_points(scene.model, data, item.geoms)
            local = (before - data.xpos[item.root]) @ data.xmat[item.root].reshape(3, 3)
            assert (local >= item.box_m[0]).all()
            assert (local <= item.box_m[1]).all()
            scene.place(data, t_s + step_s)
            after = world_points(scene.model, data, item.geoms)
            moved = np.linalg.norm(after - before, axis=1).max()
            assert moved / step_s <= motion.fastest_m_s(t_s) * 1.01
