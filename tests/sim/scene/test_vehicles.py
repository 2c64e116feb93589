from pathlib import Path

import mujoco
import numpy as np
import pytest

from sim import CrossingConfig, SceneConfigError
from sim.distractors import VehicleKind
from sim.scene import assets as assets
from sim.scene.assets import ASSETS, open_asset
from sim.scene.lighting import relative_luminance
from sim.scene.moving_objects import moving_object
from sim.scene.scene import build_scene
from sim.scene.vehicles import FLANK_OF_M, HUES, painted, vehicle
from tests.sim.shared_planes import shared_planes
from tests.sim.world_triangles import world_triangles

MOST_TRIANGLES = {"sedan": 4000, "van": 4000, "motorcycle": 4000, "pedestrian": 1000}


@pytest.mark.parametrize("name", list(MOST_TRIANGLES))
def test_a_file_opens_by_itself_and_stands_on_the_ground(name: str) -> None:
    model = mujoco.MjModel.from_xml_path(str(ASSETS / f"{name}.xml"))
    (back, right, low), (front, left, _) = moving_object(model, name, name, 1).box_m
    assert low == pytest.approx(0, abs=0.045)
    assert right == pytest.approx(-left, abs=0.02)
    assert -back == pytest.approx(front, abs=0.06)


@pytest.mark.parametrize("name", list(MOST_TRIANGLES))
def test_triangles_are_few_and_no_two_visible_faces_share_a_plane(name: str) -> None:
    spec = open_asset(f"{name}.xml")
    spec.visual.quality.numslices = 20
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    assert len(world_triangles(model, data, range(model.ngeom))) <= MOST_TRIANGLES[name]
    assert shared_planes(model) == set()


@pytest.mark.parametrize("kind", list(VehicleKind))
def test_nothing_is_transparent(kind: VehicleKind) -> None:
    model = vehicle(kind, 0.4, lit=True).compile()
    assert (model.mat_rgba[:, 3] == 1).all()
    assert (model.geom_rgba[:, 3] == 1).all()


@pytest.mark.parametrize("reflectance", [0.04, 0.1, 0.53, 0.8])
@pytest.mark.parametrize("kind", list(VehicleKind))
def test_paint_has_the_configured_reflectance(kind: VehicleKind, reflectance: float) -> None:
    model = vehicle(kind, reflectance, lit=False).compile()
    assert relative_luminance(model.mat("paint").rgba) == pytest.approx(reflectance, rel=1e-6)
    hue = np.array(painted(HUES[kind], reflectance))
    assert np.ptp(hue / HUES[kind]) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("kind", list(VehicleKind))
def test_the_near_flank_is_at_the_configured_distance(kind: VehicleKind) -> None:
    """The flank's distance is independent of the vehicle's width, so ω = v/d holds for each."""
    scene = build_scene(CrossingConfig(vehicle=kind, distance_m=7.0))
    data = mujoco.MjData(scene.model)
    scene.place(data, 0.0)
    flank_m = float(data.xpos[scene.target.root][1]) - FLANK_OF_M[kind]
    assert flank_m - float(scene.pose.position_m[1]) == pytest.approx(7.0)
    low, high = scene.target.corners_m(data)[:, 1].min(), scene.flank_m(0.0)[:, 1]
    assert low == pytest.approx(-0.9, abs=0.09)
    np.testing.assert_allclose(high, -0.9)


def test_a_missing_texture_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "wall.xml").write_text(
        '<mujoco><asset><texture name="t" type="2d" file="gone.png"/></asset></mujoco>'
    )
    monkeypatch.setattr(assets, "ASSETS", tmp_path)
    with pytest.raises(SceneConfigError, match=r"gone\.png.*Allowed are.*Install"):
        open_asset("wall.xml")


def test_a_missing_file_is_named() -> None:
    with pytest.raises(SceneConfigError, match=r"tram\.xml.*Install"):
        open_asset("tram.xml")
