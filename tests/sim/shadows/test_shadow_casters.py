"""Geoms that may shade an object, in a small world and in the whole street."""

import mujoco
import numpy as np
import pytest

from sim import CrossingConfig, Distractors, Lighting, RelativeDirection
from sim.geometry.pinhole import Intrinsics
from sim.render.filament import FilamentRenderer
from sim.render.luminance_model import luminance_model
from sim.scene.moving_objects import box_corners_m
from sim.scene.scene import build_scene
from sim.shadows import shadow_casters
from sim.shadows.shadow_casters import shadow_casting_geoms

WORLD = """
<mujoco>
  <worldbody>
    <light type="directional" dir="1 0 -1" castshadow="true" intensity="{sun}"/>
    <light type="spot" pos="0 9 1" dir="0 -1 0" castshadow="true" intensity="{lamp}"/>
    <light type="spot" pos="0 -9 1" dir="0 1 0" castshadow="false" intensity="9"/>
    <geom name="towards the sun" size=".5" pos="-10 0 10"/>
    <geom name="away from the sun" size=".5" pos="10 0 -10"/>
    <geom name="before the lamp" size=".5" pos="0 5 2"/>
    <geom name="behind the lamp" size=".5" pos="0 12 1"/>
    <geom name="beside" size=".5" pos="5 5 1"/>
    <geom name="long beside" type="box" size="4 .1 4" pos="5.5 6 1"/>
    <geom name="long across" type="box" size="4 .1 4" pos="4.5 6 1"/>
    <geom name="before a lamp without shadows" size=".5" pos="0 -5 1"/>
    <geom name="without a shadow" size=".5" pos="-10 0 10" castshadow="false"/>
    <geom name="wall" type="plane" size="0 0 1" pos="0 -20 0" euler="90 0 0"/>
  </worldbody>
</mujoco>
"""
BOX = np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 2.0]])


@pytest.mark.parametrize(
    ("sun", "lamp", "wanted"),
    [
        (1, 0, {"towards the sun", "wall"}),
        (0, 1, {"before the lamp", "long across", "wall"}),
        (0, 0, {"wall"}),
    ],
)
def test_geoms_between_an_object_and_a_light_may_shade_it(
    sun: int, lamp: int, wanted: set[str]
) -> None:
    model = mujoco.MjModel.from_xml_string(WORLD.format(sun=sun, lamp=lamp))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    found = shadow_casting_geoms(model, data, np.arange(model.ngeom), box_corners_m(BOX))
    assert {model.geom(int(k)).name for k in found} == wanted


@pytest.mark.parametrize("t_s", [-0.7, -0.2])
def test_soft_edges_of_the_suns_shadows_do_not_change(
    t_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The pedestrian walks beside a wall that nearly shades it."""
    scene = build_scene(CrossingConfig(distractors=Distractors(pedestrian=RelativeDirection.SAME)))
    model = luminance_model(scene.model)
    data = mujoco.MjData(model)
    scene.place(data, t_s)
    (pedestrian,) = (obj for obj in scene.objects if obj.name == "pedestrian")
    others = np.setdiff1d(np.arange(model.ngeom), pedestrian.geoms)
    images, rectangle = [], (0, 90, 346, 170)
    with FilamentRenderer(model, Intrinsics()) as renderer:
        renderer.update(data)
        seen = np.isin(renderer.segmentation(scene.pose, rectangle), pedestrian.geoms)
        for edge_m in (shadow_casters.SOFT_EDGE_M, 2.0):
            monkeypatch.setattr(shadow_casters, "SOFT_EDGE_M", edge_m)
            corners = pedestrian.corners_m(data)
            casters = shadow_casting_geoms(model, data, others, corners)
            with renderer.hidden(np.setdiff1d(others, casters)):
                images.append(renderer.subpixel_luminance(scene.pose, rectangle, 1)[seen])
    assert seen.sum() > 50
    assert np.abs(images[0] - images[1]).mean() < 1e-3 * images[1].mean()


def test_hiding_all_other_geoms_does_not_change_the_vehicle() -> None:
    scene = build_scene(CrossingConfig(lighting=Lighting.NIGHT))
    model = luminance_model(scene.model)
    data = mujoco.MjData(model)
    scene.place(data, -0.1)
    others = np.setdiff1d(np.arange(model.ngeom), scene.target.geoms)
    casters = shadow_casting_geoms(model, data, others, scene.target.corners_m(data))
    hidden = np.setdiff1d(others, casters)
    rectangle = (100, 110, 290, 190)
    with FilamentRenderer(model, Intrinsics()) as renderer:
        renderer.update(data)
        vehicle = np.isin(renderer.segmentation(scene.pose, rectangle), scene.target.geoms)
        whole = renderer.subpixel_luminance(scene.pose, rectangle, 1)[vehicle]
        with renderer.hidden(hidden):
            alone = renderer.subpixel_luminance(scene.pose, rectangle, 1)[vehicle]
    assert vehicle.mean() > 0.2
    np.testing.assert_array_equal(alone, whole)
    assert 0 < len(hidden) < len(others)
