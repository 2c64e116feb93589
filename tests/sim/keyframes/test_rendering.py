"""Keyframes as drawn: wheels split into albedo and light, and nothing missing behind others."""

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np
import pytest

from sim import CrossingConfig, Distractors, RelativeDirection, VehicleKind
from sim.distractors import Pavement
from sim.geometry.pinhole import Intrinsics
from sim.keyframes.mover_visibility import Outlines, parts, turning_bodies
from sim.keyframes.rendering import KeyframeDrawing, filled_ratio
from sim.raster.aperture import LENS_BLUR_PX
from sim.raster.triangles import triangle_soup
from sim.render.filament import FilamentRenderer
from sim.render.luminance_model import luminance_model
from sim.scene.scene import Scene, build_scene

LENS = Intrinsics(width=173, height=130, focal_px=162.0)
SIZE = 2


@contextmanager
def drawing(config: CrossingConfig) -> Iterator[tuple[Scene, KeyframeDrawing]]:
    """Keyframes of a scene at half the usual resolution; times are µs since closest approach."""
    scene = build_scene(config)
    model = luminance_model(scene.model)
    data = mujoco.MjData(model)
    scene.place(data, 0.0)
    moving = [int(b) for o in scene.objects for b in o.bodies]
    outlines = Outlines(
        triangle_soup(model).of_bodies(moving), parts(model, scene.objects), scene.pose, LENS, SIZE
    )
    far = np.full((LENS.height * SIZE, LENS.width * SIZE), 1e-6, np.float32)
    with FilamentRenderer(model, LENS) as renderer:
        yield (
            scene,
            KeyframeDrawing(
                renderer,
                model,
                data,
                lambda t_us: scene.place(data, t_us * 1e-6),
                outlines,
                scene.objects,
                None,
                far,
                LENS_BLUR_PX,
                SIZE,
            ),
        )


@pytest.fixture(scope="module")
def motorcycle() -> Iterator[tuple[Scene, KeyframeDrawing]]:
    with drawing(CrossingConfig(vehicle=VehicleKind.MOTORCYCLE)) as made:
        yield made


def test_albedo_times_light_is_luminance(motorcycle: tuple[Scene, KeyframeDrawing]) -> None:
    scene, draw = motorcycle
    key = draw.draw(scene.target, 0)
    body = draw.outlines.parts.body
    wheels = turning_bodies(scene.target)
    assert {int(body[k]) for k in key.glows} == set(wheels)
    for part, glow in key.glows.items():
        piece = key.pieces[part]
        assert 0.005 < piece.light.max() < 1.0
        assert (piece.cover <= 1.0 + 1e-5).all()
        assert np.isfinite(glow.light).all()
        assert glow.light.min() > 100  # of some thousand lux on the open road
        assert (glow.cover == 1).all()


def test_the_light_stays_while_the_wheel_turns(motorcycle: tuple[Scene, KeyframeDrawing]) -> None:
    scene, draw = motorcycle
    first, second = (draw.draw(scene.target, t_us) for t_us in (0, 20_000))
    root, *_ = scene.target.bodies
    for part in first.glows:
        turned = first.pieces[part].view[:, :3].T @ second.pieces[part].view[:, :3]
        assert np.linalg.norm(turned - np.eye(3)) > 0.3
        for key in (first, second):
            np.testing.assert_array_equal(key.glows[part].view, key.pieces[root].view)
        means = [np.median(key.glows[part].light) for key in (first, second)]
        assert means[0] == pytest.approx(means[1], rel=0.2)  # spokes show other places


def test_what_stands_before_an_object_leaves_no_hole_in_it() -> None:
    near = Distractors(pedestrian=RelativeDirection.SAME, pedestrian_pavement=Pavement.NEAR)
    with drawing(CrossingConfig()) as (scene, draw):
        alone = draw.draw(scene.target, 0).pieces[scene.target.root]
    with drawing(CrossingConfig(distractors=near)) as (scene, draw):
        behind = draw.draw(scene.target, 0).pieces[scene.target.root]
    assert (behind.x0, behind.y0) == (alone.x0, alone.y0)
    np.testing.assert_allclose(behind.cover, alone.cover, atol=1e-6)
    inside = alone.cover > 0.9
    off = np.abs(np.log(behind.light[0][inside] / alone.light[0][inside]))
    assert (off > 0.1).mean() < 0.1  # the walker's shadow


def test_gaps_take_the_ratio_of_their_neighbourhood() -> None:
    below = np.zeros((20, 30), np.float32)
    below[4:8, 3:9] = 0.5
    below[15, 25] = 0.25
    above = below * np.where(np.arange(30) < 15, 6.0, 2.0).astype(np.float32)
    ratio = filled_ratio(above, below)
    assert ratio[5, 5] == 6
    assert ratio[15, 25] == 2
    assert ratio[9, 9] == pytest.approx(6)
    assert ratio[16, 26] == pytest.approx(2)
    assert ((ratio >= 2 - 1e-4) & (ratio <= 6 + 1e-4)).all()


def test_where_nothing_is_seen_at_all_there_is_no_light() -> None:
    dark = np.zeros((3, 4), np.float32)
    np.testing.assert_array_equal(filled_ratio(dark, dark), dark)
