"""What moves, taken apart into bodies, lamps and the materials of open wheels."""

import mujoco
import numpy as np
import pytest

from flybench.direction import Direction
from sim import CrossingConfig, Distractors, Lighting, RelativeDirection, VehicleKind
from sim.geometry.pinhole import Intrinsics
from sim.geometry.rigid_transform import body_poses
from sim.keyframes.mover_visibility import Outlines, Parts, parts, turning_bodies
from sim.raster.scan_conversion import NOTHING
from sim.raster.triangles import triangle_soup
from sim.scene.scene import Scene, build_scene

LENS = Intrinsics(width=173, height=130, focal_px=162.0)


def scene(**options: object) -> Scene:
    return build_scene(CrossingConfig(**options))  # type: ignore[arg-type]


def names(it: Scene, found: Parts, material: str) -> set[int]:
    """Parts of the target's geoms of a material."""
    model = it.model
    return {
        int(found.of_geom[g])
        for g in it.target.geoms
        if model.mat(model.geom_matid[g]).name.endswith(material)
    }


def test_by_night_each_lamp_is_a_part_of_its_own_and_moves_with_its_body() -> None:
    it = scene(lighting=Lighting.NIGHT)
    found = parts(it.model, it.objects)
    lamps = names(it, found, "head_lamp") | names(it, found, "tail_lamp")
    assert len(lamps) >= 4
    assert min(lamps) >= it.model.nbody
    assert {int(found.body[k]) for k in lamps} == {it.target.root}
    assert names(it, found, "/paint") == {it.target.root}


def test_by_day_a_sedan_is_its_bodies() -> None:
    it = scene()
    found = parts(it.model, it.objects)
    assert len(found) == it.model.nbody
    np.testing.assert_array_equal(found.body, np.arange(it.model.nbody))


def test_the_materials_of_a_motorcycles_wheels_are_parts() -> None:
    it = scene(vehicle=VehicleKind.MOTORCYCLE)
    found = parts(it.model, it.objects)
    wheels = set(turning_bodies(it.target))
    rubber, rim = names(it, found, "rubber"), names(it, found, "rim")
    assert len(wheels) == 2
    assert not rubber & rim
    assert {int(found.body[k]) for k in rubber} == wheels


def test_only_vehicles_have_bodies_that_turn_on_and_on() -> None:
    it = scene(distractors=Distractors(pedestrian=RelativeDirection.SAME, wind_grade=3))
    turning = {obj.name: turning_bodies(obj) for obj in it.objects}
    assert len(turning["target"]) == 4
    assert not any(bodies for name, bodies in turning.items() if name != "target")


def test_labels_of_parts_become_those_of_bodies() -> None:
    found = Parts(np.zeros(0, np.int32), np.array([0, 1, 2, 1], np.int32))
    label = np.array([[NOTHING, 3], [2, 1]], np.int32)
    np.testing.assert_array_equal(found.bodies(label), [[NOTHING, 1], [2, 1]])


@pytest.mark.parametrize("direction", [Direction.RIGHT, Direction.UP])
def test_windows_hold_every_point_that_an_object_covers(direction: Direction) -> None:
    it = scene(direction=direction, lighting=Lighting.DUSK)
    data = mujoco.MjData(it.model)
    it.place(data, 0.0)
    movers = triangle_soup(it.model).of_bodies(it.target.bodies)
    outlines = Outlines(movers, parts(it.model, it.objects), it.pose, LENS, 2)
    flat, part = outlines.project(body_poses(data))
    (rectangle,) = outlines.rectangles(flat, part, it.objects)
    far = np.full((LENS.height * 2, LENS.width * 2), 1e-6, np.float32)
    label, nearness = outlines.points(flat, part, (0, 0, LENS.width, LENS.height), far)
    assert rectangle is not None
    x0, y0, x1, y1 = (2 * edge for edge in rectangle)
    assert (label[y0:y1, x0:x1] != NOTHING).sum() == (label != NOTHING).sum() > 1000
    assert set(np.unique(label)) - {NOTHING} <= set(outlines.of(it.target))
    assert (nearness[label != NOTHING] > 1 / 20).all()


def test_what_is_out_of_view_has_no_window() -> None:
    it = scene()
    data = mujoco.MjData(it.model)
    it.place(data, -60.0)
    movers = triangle_soup(it.model).of_bodies(it.target.bodies)
    outlines = Outlines(movers, parts(it.model, it.objects), it.pose, LENS, 2)
    assert outlines.rectangles(*outlines.project(body_poses(data)), it.objects) == [None]
