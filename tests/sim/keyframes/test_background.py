"""The background's layers, weighted and summed, equal what the renderer gives."""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim.compositing.background import Background
from sim.geometry.pinhole import Intrinsics, Pose
from sim.keyframes.background import background_of
from sim.keyframes.background_layers import BackgroundLight, render_light
from sim.raster.aperture import to_pixels
from sim.raster.triangles import triangle_soup
from sim.render.filament import FilamentRenderer
from sim.scene.lamp_flicker import FlickeringLamps, changed_lights
from tests.sim.flat_background import composited, effects

F32 = npt.NDArray[np.float32]

LENS = Intrinsics(width=64, height=48, focal_px=50.0)
WHOLE = (0, 0, LENS.width, LENS.height)
PART = (10, 8, 50, 40)
POSE = Pose(np.array([0.0, -4.0, 1.2]))
SUPERSAMPLE = 2
SKY, SUN, LAMP, HALF = range(4)
MODEL = """<mujoco>
  <custom>
    <text name="filament.material.base_color_type" data="linear"/>
    <numeric name="filament.ao.enabled" data="0"/>
  </custom>
  <asset>
    <texture name="sky" type="skybox" builtin="flat" rgb1="1 1 1" rgb2="1 1 1" width="8"
      height="48"/>
    <material name="matte" rgba=".5 .5 .5 1" metallic="0" roughness="1"/>
    <material name="glass" rgba=".1 .1 .1 1" metallic="0" roughness="1" emission=".02"/>
    <material name="sign" rgba=".1 .1 .1 1" metallic="0" roughness="1" emission=".01"/>
  </asset>
  <worldbody>
    <light type="image" texture="sky" diffuse="1 1 1" intensity="20"/>
    <light type="directional" dir=".4 .5 -1" diffuse="1 1 1" intensity="300" castshadow="true"/>
    <light type="spot" pos="1.5 -.5 3" dir="-.3 0 -1" cutoff="60" diffuse="1 1 1" range="50"
      intensity="900" castshadow="true"/>
    <light type="spot" pos="-2 -1 3" dir="0 0 -1" cutoff="60" diffuse="1 1 1" range="50"
      intensity="500" castshadow="false"/>
    <geom type="plane" size="20 20 .1" material="matte"/>
    <geom type="box" size=".4 .3 .6" pos="-.5 .5 .6" euler="0 0 30" material="matte"/>
    <geom type="box" size=".3 .1 .2" pos=".8 .5 1" material="glass"/>
    <geom type="box" size=".2 .1 .2" pos="-1.6 .5 1" material="sign"/>
  </worldbody>
</mujoco>"""
SHADOW_LIGHTS = np.array([SUN, LAMP])
FLICKERING = FlickeringLamps(lights=np.array([LAMP, HALF]), materials=np.array([1]))


class World:
    """A static scene and its renderer."""

    def __init__(self) -> None:
        self.model = mujoco.MjModel.from_xml_string(MODEL)
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)
        self.renderer = FilamentRenderer(self.model, LENS)

    def background(
        self, flickering: FlickeringLamps | None, rectangle: tuple[int, int, int, int] = WHOLE
    ) -> Background:
        light = render_light(
            self.renderer,
            self.model,
            self.data,
            POSE,
            SHADOW_LIGHTS,
            flickering,
            rectangle,
            SUPERSAMPLE,
        )
        light = BackgroundLight.from_bytes(light.to_bytes())
        soup, blur_px = triangle_soup(self.model), 0.35
        return background_of(light, LENS, self.data, POSE, soup, SUPERSAMPLE, blur_px)

    def image(self) -> F32:
        self.renderer.update(self.data)
        return self.renderer.luminance(POSE, WHOLE, supersample=SUPERSAMPLE)


@pytest.fixture(scope="module")
def world() -> Iterator[World]:
    made = World()
    yield made
    made.renderer.close()


def weighted_sum(background: Background, gains: Sequence[float]) -> F32:
    return np.tensordot(np.array(gains, np.float32), background.pixels, axes=1)


@pytest.mark.parametrize("flickering", [None, FLICKERING])
@pytest.mark.parametrize("rectangle", [WHOLE, PART])
def test_the_sum_of_the_layers_is_the_image(
    world: World, flickering: FlickeringLamps | None, rectangle: tuple[int, int, int, int]
) -> None:
    background = world.background(flickering, rectangle)
    layers = 3 if flickering is None else 4
    assert background.pixels.shape == (layers, 48, 64)
    assert background.subpixels.shape == (layers, 96, 128)
    np.testing.assert_allclose(background.pixels.sum(axis=0), world.image(), rtol=1e-4)
    outside = np.ones((48, 64), bool)
    x0, y0, x1, y1 = rectangle
    outside[max(y0 - 1, 0) : y1 + 1, max(x0 - 1, 0) : x1 + 1] = False
    assert (background.pixels[1:3, outside] == 0).all()


@pytest.mark.parametrize(("layer", "light"), [(1, SUN), (2, LAMP)])
@pytest.mark.parametrize("gain", [0.0, 0.4, 1.5])
def test_changing_a_light_equals_scaling_its_layer(
    world: World, layer: int, light: int, gain: float
) -> None:
    gains = np.ones(3)
    gains[layer] = gain
    background = world.background(None)
    with changed_lights(world.model, {light: gain * world.model.light_intensity[light]}):
        wanted = world.image()
    np.testing.assert_allclose(weighted_sum(background, list(gains)), wanted, rtol=2e-3)
    lit = background.pixels[layer]
    assert lit.max() > 10
    assert lit.min() < 1e-3 * lit.max()  # in its shadow


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.5])
@pytest.mark.parametrize("rectangle", [WHOLE, PART])
def test_flicker_equals_scaling_the_layers_of_flickering_lamps(
    world: World, factor: float, rectangle: tuple[int, int, int, int]
) -> None:
    """Within the rectangle, the flickering lamp that casts shadows has a separate layer."""
    background = world.background(FLICKERING, rectangle)
    with FLICKERING.scaled(world.model, factor):
        wanted = world.image()
    image = weighted_sum(background, [1.0, 1.0, factor, factor])
    np.testing.assert_allclose(image, wanted, rtol=2e-3)
    assert np.abs(image - weighted_sum(background, [1.0] * 4)).max() > 0.2 * wanted.max()


def test_the_model_is_restored(world: World) -> None:
    before = world.model.light_intensity.copy(), world.model.mat_emission.copy()
    world.background(FLICKERING)
    np.testing.assert_array_equal(world.model.light_intensity, before[0])
    np.testing.assert_array_equal(world.model.mat_emission, before[1])


def test_albedo_is_luminance_per_lux(world: World) -> None:
    albedo = to_pixels(world.background(None, PART).subpixel_albedo, SUPERSAMPLE)
    assert albedo[37, 30] == pytest.approx(0.5 / np.pi, rel=0.05)
    assert albedo[26, 41] == pytest.approx(0.1 / np.pi, rel=0.25)  # glass, without its emission
    assert (albedo[:6] == 0).all()


def test_geometry_is_that_of_the_ground(world: World) -> None:
    """Below the horizon at row 24, the ground is height · focal / (row - 24) away."""
    background = world.background(None)
    np.testing.assert_allclose(background.nearness[44], 20.5 / (1.2 * 50), rtol=1e-5)
    np.testing.assert_allclose(background.subpixel_nearness[89], 20.75 / (1.2 * 50), rtol=1e-5)
    np.testing.assert_allclose(background.normals[:, 44].T, np.tile([0, -1, 0], (64, 1)), atol=1e-6)
    assert (background.nearness[2, 60:] < 1e-5).all()
    assert (background.normals[:, 2, 60:] == 0).all()


def test_without_movers_compositing_gives_the_rendered_image(world: World) -> None:
    image = composited(world.background(FLICKERING), effects(1.0, 1.0, 1.0, 1.0), lens=LENS)
    np.testing.assert_allclose(image, world.image(), rtol=1e-4)
