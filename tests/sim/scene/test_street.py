import itertools

import mujoco
import numpy as np
import pytest

from sim import CrossingConfig, Lighting
from sim.scene.facade_style import LIT_CD_M2, LIT_RGB
from sim.scene.lighting import EMISSION_CD_M2, relative_luminance
from sim.scene.movers import FAR_LANE_M
from sim.scene.scene import build_spec
from sim.scene.street import CAR_M, LAMP_CLEARANCE_M, LAMP_X_M, build_street, plan_trees
from tests.sim.shared_planes import shared_planes

EYE_M = np.array([0.0, -7.8, 1.2])


def model_of(seed: int, lighting: Lighting = Lighting.DAY) -> mujoco.MjModel:
    return build_spec(CrossingConfig(street_seed=seed, lighting=lighting)).compile()


def test_a_seed_gives_the_same_street_and_another_seed_another() -> None:
    first, again, other = model_of(1), model_of(1), model_of(2)
    np.testing.assert_array_equal(first.geom_pos, again.geom_pos)
    np.testing.assert_array_equal(first.mat_rgba, again.mat_rgba)
    np.testing.assert_array_equal(first.mesh_vert, again.mesh_vert)
    assert first.ngeom != other.ngeom or not np.array_equal(first.geom_pos, other.geom_pos)


@pytest.mark.parametrize("seed", range(4))
def test_no_two_visible_faces_share_a_plane(seed: int) -> None:
    spec, _ = build_street(seed, dark=True, windy=False)
    assert shared_planes(spec.compile(), within_m=14.0, eye_m=EYE_M) == set()


@pytest.mark.parametrize("seed", range(6))
def test_parked_cars_keep_apart_and_off_the_lane(seed: int) -> None:
    model = model_of(seed)
    names = [model.body(k).name for k in range(model.nbody)]
    parked = [k for k, name in enumerate(names) if name.split("/")[-1] in tuple(CAR_M)]
    parked = [k for k in parked if names[k].startswith("parked")]
    assert 2 <= len(parked) <= 5
    spans = sorted((model.body_pos[k, 0], CAR_M[names[k].split("/")[1]] / 2) for k in parked)
    for (x0, half0), (x1, half1) in itertools.pairwise(spans):
        assert x1 - half1 - (x0 + half0) > 0.5
    assert all(model.body_pos[k, 1] - 1.1 > FAR_LANE_M + 1.15 for k in parked)


@pytest.mark.parametrize("seed", range(10))
def test_trees_keep_clear_of_the_lamp_and_each_other(seed: int) -> None:
    trees = plan_trees(np.random.default_rng(seed))
    places = [tree.x_m for tree in trees]
    assert min(abs(x - LAMP_X_M) for x in places) >= LAMP_CLEARANCE_M
    assert min(np.diff(places)) > 2.5
    assert len({tree.seed for tree in trees}) == len(trees)


def test_no_two_trees_have_the_same_leaves() -> None:
    model = model_of(0)
    starts = [model.mesh_vertadr[k] for k in range(model.nmesh) if "leaves" in model.mesh(k).name]
    shapes = {model.mesh_vert[start : start + 20].tobytes() for start in starts}
    assert len(shapes) == len(starts) >= 8


def test_neighbouring_houses_differ() -> None:
    model = model_of(0)
    walls = [k for k in range(model.nmat) if model.mat(k).name.startswith("wall")]
    assert len(walls) >= 6
    for one, other in itertools.pairwise(walls):
        step = np.abs(model.mat_rgba[one] - model.mat_rgba[other]).max()
        assert step > 0.05 or (model.mat_texid[one] != model.mat_texid[other]).any()


@pytest.mark.parametrize("lighting", [Lighting.DUSK, Lighting.NIGHT])
def test_windows_are_lit_after_dark_and_only_then(lighting: Lighting) -> None:
    dark, day = model_of(0, lighting), model_of(0, Lighting.DAY)

    def panes(model: mujoco.MjModel) -> dict[str, int]:
        materials = [model.mat(k).name for k in model.geom_matid]
        return {name: materials.count(f"mains_window_{name}") for name in LIT_CD_M2}

    assert sum(panes(day).values()) == 0
    assert min(panes(dark).values()) > 0
    assert dark.ngeom == day.ngeom
    for name, luminance in LIT_CD_M2.items():
        emission = float(dark.mat(f"mains_window_{name}").emission[0])
        glow = emission * EMISSION_CD_M2 * relative_luminance(LIT_RGB[name])
        assert glow == pytest.approx(luminance, rel=1e-4)
