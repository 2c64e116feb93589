"""Rendered keyframes: albedo and illumination of wheels, and occluded objects."""

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np
import pytest

from sim import CrossingConfig, Distractors, RelativeDirection, VehicleKind
from sim.distractors import Pavement
from sim.geometry.pinhole import Intrinsics
from sim.keyframes.mover_visibility import MoverRaster, split_into_parts, wheel_bodies
from sim.keyframes.rendering import KeyframeRenderer, gap_filled_ratio
from sim.raster.aperture import LENS_BLUR_PX
from sim.raster.triangles import triangle_soup
from sim.render.filament import FilamentRenderer
from sim.render.luminance_model import luminance_model
from sim.scene.scene import Scene, build_scene

LENS = Intrinsics(width=173, height=130, focal_px=162.0)
SUPERSAMPLE = 2


@contextmanager
def keyframe_renderer(config: CrossingConfig) -> Iterator[tuple[Scene, KeyframeRenderer]]:
    """Yield a scene and its renderer at half the usual resolution.

    Times are µs since closest approach.
    """
    scene = build_scene(config)
    model = luminance_model(scene.model)
    data = mujoco.MjData(model)
    scene.place(data, 0.0)
    moving = [int(b) for o in scene.objects for b in o.bodies]
    raster = MoverRaster(
        triangle_soup(model).of_bodies(moving),
        split_into_parts(model, scene.objects),
        scene.pose,
        LENS,
        SUPERSAMPLE,
    )
    far = np.full((LENS.height * SUPERSAMPLE, LENS.width * SUPERSAMPLE), 1e-6, np.float32)
    with FilamentRenderer(model, LENS) as renderer:
        yield (
            scene,
            KeyframeRenderer(
                renderer,
                model,
                data,
                lambda t_us: scene.place(data, t_us * 1e-6),
                raster,
                scene.objects,
                None,
                far,
                LENS_BLUR_PX,
                SUPERSAMPLE,
            ),
        )


@pytest.fixture(scope="module")
def motorcycle() -> Iterator[tuple[Scene, KeyframeRenderer]]:
    with keyframe_renderer(CrossingConfig(vehicle=VehicleKind.MOTORCYCLE)) as made:
        yield made


def test_wheels_have_an_albedo_and_an_illumination(
    motorcycle: tuple[Scene, KeyframeRenderer],
) -> None:
    scene, renderer = motorcycle
    key = renderer.render(scene.target, 0)
    body = renderer.raster.parts.body
    wheels = wheel_bodies(scene.target)
    assert {int(body[k]) for k in key.illumination} == set(wheels)
    for part, illumination in key.illumination.items():
        patch = key.patches[part]
        assert 0.005 < patch.luminance.max() < 1.0
        assert (patch.coverage <= 1.0 + 1e-5).all()
        assert np.isfinite(illumination.luminance).all()
        assert illumination.luminance.min() > 100  # of some thousand lux on the open road
        assert (illumination.coverage == 1).all()


def test_the_illumination_stays_while_the_wheel_rotates(
    motorcycle: tuple[Scene, KeyframeRenderer],
) -> None:
    scene, renderer = motorcycle
    first, second = (renderer.render(scene.target, t_us) for t_us in (0, 20_000))
    root, *_ = scene.target.bodies
    for part in first.illumination:
        rotation = first.patches[part].view[:, :3].T @ second.patches[part].view[:, :3]
        assert np.linalg.norm(rotation - np.eye(3)) > 0.3
        for key in (first, second):
            np.testing.assert_array_equal(key.illumination[part].view, key.patches[root].view)
        medians = [np.median(key.illumination[part].luminance) for key in (first, second)]
        assert medians[0] == pytest.approx(medians[1], rel=0.2)  # the spokes sample other places


def test_an_occluder_leaves_no_gap_in_an_object() -> None:
    near = Distractors(pedestrian=RelativeDirection.SAME, pedestrian_pavement=Pavement.NEAR)
    with keyframe_renderer(CrossingConfig()) as (scene, renderer):
        alone = renderer.render(scene.target, 0).patches[scene.target.root]
    with keyframe_renderer(CrossingConfig(distractors=near)) as (scene, renderer):
        behind = renderer.render(scene.target, 0).patches[scene.target.root]
    assert (behind.x0, behind.y0) == (alone.x0, alone.y0)
    np.testing.assert_allclose(behind.coverage, alone.coverage, atol=1e-6)
    inside = alone.coverage > 0.9
    difference = np.abs(np.log(behind.luminance[0][inside] / alone.luminance[0][inside]))
    assert (difference > 0.1).mean() < 0.1  # the pedestrian's shadow


def test_gaps_are_filled_with_the_ratio_of_their_neighbourhood() -> None:
    denominator = np.zeros((20, 30), np.float32)
    denominator[4:8, 3:9] = 0.5
    denominator[15, 25] = 0.25
    numerator = denominator * np.where(np.arange(30) < 15, 6.0, 2.0).astype(np.float32)
    ratio = gap_filled_ratio(numerator, denominator)
    assert ratio[5, 5] == 6
    assert ratio[15, 25] == 2
    assert ratio[9, 9] == pytest.approx(6)
    assert ratio[16, 26] == pytest.approx(2)
    assert ((ratio >= 2 - 1e-4) & (ratio <= 6 + 1e-4)).all()


def test_the_ratio_is_zero_if_the_denominator_is_zero_everywhere() -> None:
    zero = np.zeros((3, 4), np.float32)
    np.testing.assert_array_equal(gap_filled_ratio(zero, zero), zero)
