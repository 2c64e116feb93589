"""Scenes, compiled and rendered: moving objects, lit lamps, and a constant background."""

import itertools
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest

from flybench.direction import CARDINAL, Direction
from sim import CrossingConfig, Intrinsics, Lighting, project
from sim.distractors import Distractors, Pavement, RelativeDirection, VehicleKind
from sim.render.filament import FilamentRenderer, Luminance
from sim.render.luminance_model import luminance_model
from sim.scene.scene import Scene, build_scene, build_spec

EVERYTHING = Distractors(
    wind_grade=4,
    far_vehicle=RelativeDirection.OPPOSITE,
    far_vehicle_kind=VehicleKind.VAN,
    pedestrian=RelativeDirection.SAME,
    shake_rms_deg=0.1,
    flicker_hz=100,
)


COARSE = Intrinsics(width=86, height=64, focal_px=80.0)


@pytest.mark.parametrize(
    ("kind", "direction", "lighting"),
    list(itertools.product(VehicleKind, CARDINAL, Lighting)),
)
def test_every_vehicle_goes_in_every_direction_at_any_time_of_day(
    kind: VehicleKind, direction: Direction, lighting: Lighting
) -> None:
    scene = build_scene(CrossingConfig(vehicle=kind, direction=direction, lighting=lighting))
    (target,) = scene.objects
    assert (target.name, target.kind) == ("target", kind)
    assert bool(target.lamps.size) == (lighting is not Lighting.DAY)
    data = mujoco.MjData(scene.model)
    middle = []
    for t_s in (-0.1, 0.1):
        scene.place(data, t_s)
        pixels, depth = project(target.corners_m(data), scene.pose_at(t_s), Intrinsics())
        assert (depth > 0).all()
        middle.append(pixels.mean(axis=0))
    along = {"right": [1, 0], "left": [-1, 0], "up": [0, -1], "down": [0, 1]}[direction]
    assert (middle[1] - middle[0]) @ along > 50


def test_objects_are_named_and_own_their_bodies_geoms_and_lamps() -> None:
    scene = build_scene(CrossingConfig(lighting=Lighting.NIGHT, distractors=EVERYTHING))
    names = [item.name for item in scene.objects]
    assert names[:3] == ["target", "far_vehicle", "pedestrian"]
    assert all(name == f"tree_{k}" for k, name in enumerate(names[3:]))
    moving = np.flatnonzero(scene.model.body_weldid)
    owned = np.concatenate([item.bodies for item in scene.objects])
    assert sorted(owned) == sorted(moving)
    geoms = np.concatenate([item.geoms for item in scene.objects])
    assert len(set(geoms)) == len(geoms)
    assert set(geoms) == set(np.flatnonzero(np.isin(scene.model.geom_bodyid, moving)))
    assert all(item.lamps.size == 3 for item in scene.objects[:2])
    assert all(item.lamps.size == 0 for item in scene.objects[2:])


def test_only_the_configured_objects_move() -> None:
    scene = build_scene(CrossingConfig())
    assert [item.name for item in scene.objects] == ["target"]
    assert set(np.flatnonzero(scene.model.body_weldid)) == set(scene.target.bodies)
    assert scene.shake is None
    assert scene.flicker is None
    assert scene.flicker_factor(0.123) == 1.0


def test_lamps_on_the_mains_are_the_street_lamps_and_the_lit_windows() -> None:
    scene = build_scene(CrossingConfig(lighting=Lighting.NIGHT, distractors=EVERYTHING))
    model = scene.model
    lights = {model.light(k).name for k in scene.flickering_lights}
    assert lights == {"street_lamp_0", "street_lamp_1", "street_lamp_2"}
    materials = {model.mat(k).name for k in scene.flickering_materials}
    windows = {f"mains_window_{name}" for name in ("warm", "bright", "dim")}
    assert materials == windows | {"mains_lamp_lens"}
    assert not set(scene.flickering_lights) & {int(k) for item in scene.objects for k in item.lamps}


def test_lanes_keep_vehicles_and_pedestrians_apart() -> None:
    """No two things overlap across the road, for any configuration."""
    for target, far in itertools.product(VehicleKind, VehicleKind):
        extra = Distractors(
            far_vehicle=RelativeDirection.SAME,
            far_vehicle_kind=far,
            pedestrian=RelativeDirection.SAME,
        )
        near = Distractors(pedestrian=RelativeDirection.SAME, pedestrian_pavement=Pavement.NEAR)
        spans = []
        for distractors in (extra, near):
            scene = build_scene(CrossingConfig(vehicle=target, distractors=distractors))
            data = mujoco.MjData(scene.model)
            scene.place(data, 0.0)
            corners = [item.corners_m(data)[:, 1] for item in scene.objects]
            spans = sorted((float(y.min()), float(y.max())) for y in corners)
            assert all(a[1] < b[0] for a, b in itertools.pairwise(spans))


@contextmanager
def rendered(scene: Scene, lens: Intrinsics = COARSE) -> Iterator[Any]:
    """Yield a function that renders a scene at a time."""
    grey = luminance_model(scene.model)
    with FilamentRenderer(grey, lens) as renderer:
        data = mujoco.MjData(grey)

        def draw(t_s: float) -> Luminance:
            scene.place(data, t_s)
            renderer.update(data)
            return renderer.luminance(scene.pose_at(t_s), (0, 0, lens.width, lens.height))

        yield draw


@pytest.mark.parametrize("lighting", list(Lighting))
def test_the_image_is_constant_when_nothing_moves(lighting: Lighting) -> None:
    scene = build_scene(CrossingConfig(lighting=lighting))
    away_s = scene.trajectory.time_at_s(40.0)
    with rendered(scene) as draw:
        first = draw(away_s)
        assert np.array_equal(first, draw(away_s))
        assert (first > 0).all()


def test_each_distractor_changes_the_image() -> None:
    for extra in (
        Distractors(wind_grade=6),
        Distractors(far_vehicle=RelativeDirection.SAME, far_vehicle_lag_s=-2.0),
        Distractors(pedestrian=RelativeDirection.OPPOSITE, pedestrian_lag_s=-2.0),
        Distractors(shake_rms_deg=0.5),
    ):
        scene = build_scene(CrossingConfig(distractors=extra))
        gone_s = -2.0  # the target is still far off
        with rendered(scene) as draw:
            changed = np.abs(np.log(draw(gone_s) / draw(gone_s + 0.1))) > 0.05
        assert changed.mean() > 0.001, extra


def test_paint_reflects_the_share_of_light_that_its_reflectance_says() -> None:
    """Luminance of a level patch of paint grows by Δρ·E/π; the gloss is constant."""
    seen = []
    for reflectance in (0.04, 0.8):
        config = CrossingConfig(paint_reflectance=reflectance, illuminance_lux=10_000.0)
        spec = build_spec(config)
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[1.0, 0.8, 0.005],
            material="vehicle/paint",
            castshadow=False,
        )
        scene = replace(build_scene(config), model=spec.compile())
        middle, _ = project(np.array([[0.0, 0.0, 0.01]]), scene.pose, COARSE)
        with rendered(scene) as draw:
            x, y = map(int, middle[0])
            seen.append(float(draw(scene.trajectory.time_at_s(15.0))[y, x]))
    gain = (seen[1] - seen[0]) * math.pi / 10_000.0
    assert gain == pytest.approx(0.76, rel=0.05)
    # Seen at 8° above its plane, the gloss adds about as much again to black.
    assert 0.04 < seen[0] * math.pi / 10_000.0 < 0.1


def test_paint_of_the_roads_reflectance_is_almost_invisible() -> None:
    """The contrast of flank and road changes its sign from dark to bright paint."""
    contrast = []
    for reflectance in (0.04, 0.13, 0.8):
        config = CrossingConfig(paint_reflectance=reflectance, vehicle=VehicleKind.VAN)
        scene, lens = build_scene(config), Intrinsics()
        points = np.array([[-0.3, -0.97, 0.8], [-3.6, 0.6, 0.0]])
        pixels, _ = project(points, scene.pose, lens)
        with rendered(scene, lens) as draw:
            image = draw(0.0)
        (x0, y0), (x1, y1) = pixels.astype(int)
        contrast.append(math.log(image[y0, x0] / image[y1, x1]))
    assert contrast[0] < contrast[1] < contrast[2]
    assert abs(contrast[1]) < 0.15
    assert contrast[0] < -0.7
    assert contrast[2] > 1.4
