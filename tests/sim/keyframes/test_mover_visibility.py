"""Moving objects are split into bodies, lamps and the materials of open wheels."""

import mujoco
import numpy as np
import pytest

from flybench.direction import Direction
from sim import CrossingConfig, Distractors, Lighting, RelativeDirection, VehicleKind
from sim.geometry.pinhole import Intrinsics
from sim.geometry.rigid_transform import body_poses
from sim.keyframes.mover_visibility import (
    MoverParts,
    MoverRaster,
    split_into_parts,
    wheel_bodies,
)
from sim.raster.scan_conversion import NO_LABEL
from sim.raster.triangles import triangle_soup
from sim.scene.scene import Scene, build_scene

LENS = Intrinsics(width=173, height=130, focal_px=162.0)


def scene_with(**options: object) -> Scene:
    return build_scene(CrossingConfig(**options))  # type: ignore[arg-type]


def parts_of_material(scene: Scene, parts: MoverParts, material: str) -> set[int]:
    """Return the parts of the target's geoms whose material's name has an ending."""
    model = scene.model
    return {
        int(parts.of_geom[g])
        for g in scene.target.geoms
        if model.mat(model.geom_matid[g]).name.endswith(material)
    }


def target_raster(scene: Scene) -> MoverRaster:
    movers = triangle_soup(scene.model).of_bodies(scene.target.bodies)
    return MoverRaster(movers, split_into_parts(scene.model, scene.objects), scene.pose, LENS, 2)


def test_by_night_each_lamp_is_a_separate_part_that_moves_with_its_body() -> None:
    scene = scene_with(lighting=Lighting.NIGHT)
    parts = split_into_parts(scene.model, scene.objects)
    lamps = parts_of_material(scene, parts, "head_lamp")
    lamps |= parts_of_material(scene, parts, "tail_lamp")
    assert len(lamps) >= 4
    assert min(lamps) >= scene.model.nbody
    assert {int(parts.body[k]) for k in lamps} == {scene.target.root}
    assert parts_of_material(scene, parts, "/paint") == {scene.target.root}


def test_by_day_the_parts_of_a_sedan_are_its_bodies() -> None:
    scene = scene_with()
    parts = split_into_parts(scene.model, scene.objects)
    assert len(parts) == scene.model.nbody
    np.testing.assert_array_equal(parts.body, np.arange(scene.model.nbody))


def test_each_material_of_a_motorcycles_wheels_is_a_separate_part() -> None:
    scene = scene_with(vehicle=VehicleKind.MOTORCYCLE)
    parts = split_into_parts(scene.model, scene.objects)
    wheels = set(wheel_bodies(scene.target))
    rubber = parts_of_material(scene, parts, "rubber")
    rim = parts_of_material(scene, parts, "rim")
    assert len(wheels) == 2
    assert not rubber & rim
    assert {int(parts.body[k]) for k in rubber} == wheels


def test_only_vehicles_have_wheels() -> None:
    scene = scene_with(distractors=Distractors(pedestrian=RelativeDirection.SAME, wind_grade=3))
    wheels = {obj.name: wheel_bodies(obj) for obj in scene.objects}
    assert len(wheels["target"]) == 4
    assert not any(bodies for name, bodies in wheels.items() if name != "target")


@pytest.mark.parametrize("direction", [Direction.RIGHT, Direction.UP])
def test_an_objects_rectangle_holds_every_subpixel_that_it_covers(direction: Direction) -> None:
    scene = scene_with(direction=direction, lighting=Lighting.DUSK)
    data = mujoco.MjData(scene.model)
    scene.place(data, 0.0)
    raster = target_raster(scene)
    projected, part = raster.project(body_poses(data))
    (rectangle,) = raster.rectangles(projected, part, scene.objects)
    far = np.full((LENS.height * 2, LENS.width * 2), 1e-6, np.float32)
    image = (0, 0, LENS.width, LENS.height)
    label, nearness = raster.rasterise(projected, part, image, far)
    assert rectangle is not None
    x0, y0, x1, y1 = (2 * edge for edge in rectangle)
    assert (label[y0:y1, x0:x1] != NO_LABEL).sum() == (label != NO_LABEL).sum() > 1000
    assert set(np.unique(label)) - {NO_LABEL} <= set(raster.parts_of(scene.target))
    assert (nearness[label != NO_LABEL] > 1 / 20).all()


def test_an_object_out_of_view_has_no_rectangle() -> None:
    scene = scene_with()
    data = mujoco.MjData(scene.model)
    scene.place(data, -60.0)
    raster = target_raster(scene)
    assert raster.rectangles(*raster.project(body_poses(data)), scene.objects) == [None]
