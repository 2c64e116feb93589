"""Spot lights that cannot light an object."""

import mujoco
import numpy as np
import pytest

from sim import CrossingConfig, Lighting, VehicleKind
from sim.geometry.pinhole import Intrinsics
from sim.geometry.rigid_transform import body_poses
from sim.render.filament import FilamentRenderer
from sim.render.luminance_model import luminance_model
from sim.scene.lamp_flicker import changed_lights
from sim.scene.scene import build_scene
from sim.shadows.beams_that_miss import beams_that_miss

LAMP = '<mujoco><worldbody><light type="spot" dir="1 0 0" cutoff="45"/></worldbody></mujoco>'
TRIANGLE = np.array([[0.0, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.3]])
AHEAD = np.array([3.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("position", "is_missed"),
    [
        ([5, 0, 0], False),
        ([5, 4.8, 0], False),
        ([5, 5.1, 0], True),
        ([5, -5.2, 0], False),  # one corner is inside
        ([5, -5.4, 0], True),
        ([0, 5, 0], True),
        ([0.1, 0, 0], False),
        ([-0.1, 0, 0], True),
    ],
)
def test_a_beam_misses_what_is_outside_its_cone(position: list[float], is_missed: bool) -> None:
    model = mujoco.MjModel.from_xml_string(LAMP)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    missed = beams_that_miss(model, data, np.array([0]), (TRIANGLE + position)[None])
    assert missed.tolist() == [0] * is_missed


def test_one_triangle_in_the_cone_is_enough() -> None:
    model = mujoco.MjModel.from_xml_string(LAMP)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    triangles = np.stack([TRIANGLE - AHEAD, TRIANGLE + AHEAD])
    assert beams_that_miss(model, data, np.array([0]), triangles).size == 0


@pytest.mark.parametrize("vehicle", list(VehicleKind))
def test_a_vehicles_own_beams_can_be_off_while_it_is_rendered(vehicle: VehicleKind) -> None:
    scene = build_scene(CrossingConfig(lighting=Lighting.NIGHT, vehicle=vehicle))
    model = luminance_model(scene.model)
    data = mujoco.MjData(model)
    scene.place(data, -0.1)
    target, rectangle = scene.target, (100, 110, 290, 190)
    triangles = scene.soup.of_bodies(target.bodies).transformed(body_poses(data))
    spots = np.flatnonzero(model.light_type == mujoco.mjtLightType.mjLIGHT_SPOT)
    missing = beams_that_miss(model, data, spots, triangles)
    assert missing.tolist() == target.lamps.tolist()
    others = np.setdiff1d(np.arange(model.ngeom), target.geoms)
    with FilamentRenderer(model, Intrinsics()) as renderer, renderer.hidden(others):
        images = []
        for off in ({}, dict.fromkeys(missing.tolist(), 0.0)):
            with changed_lights(model, off):
                renderer.update(data)
                images.append(renderer.subpixel_luminance(scene.pose, rectangle, 1))
    assert (images[0] > 0).mean() > 0.1
    np.testing.assert_array_equal(images[0], images[1])
