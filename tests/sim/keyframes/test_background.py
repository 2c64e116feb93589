"""The street taken apart by light: its parts, put together anew, are what the renderer draws."""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Intrinsics, Pose
from sim.keyframes.background import Background, render_background
from sim.raster.aperture import to_pixels
from sim.raster.triangles import triangle_soup
from sim.render.filament import FilamentRenderer
from sim.scene.lamp_flicker import FlickeringLamps, changed_lights
from tests.sim.flat import composed, lights

F32 = npt.NDArray[np.float32]

LENS = Intrinsics(width=64, height=48, focal_px=50.0)
WHOLE = (0, 0, LENS.width, LENS.height)
PART = (10, 8, 50, 40)
POSE = Pose(np.array([0.0, -4.0, 1.2]))
SIZE = 2
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
SHADOWING = np.array([SUN, LAMP])
MAINS = FlickeringLamps(lights=np.array([LAMP, HALF]), materials=np.array([1]))


class World:
    """A still street and its renderer."""

    def __init__(self) -> None:
        self.model = mujoco.MjModel.from_xml_string(MODEL)
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)
        self.renderer = FilamentRenderer(self.model, LENS)

    def street(
        self, mains: FlickeringLamps | None, rectangle: tuple[int, int, int, int] = WHOLE
    ) -> Background:
        soup, blur_px = triangle_soup(self.model), 0.35
        return render_background(
            self.renderer,
            self.model,
            self.data,
            POSE,
            soup,
            SHADOWING,
            mains,
            rectangle,
            SIZE,
            blur_px,
        )

    def drawn(self) -> F32:
        self.renderer.update(self.data)
        return self.renderer.luminance(POSE, WHOLE, supersample=SIZE)


@pytest.fixture(scope="module")
def world() -> Iterator[World]:
    it = World()
    yield it
    it.renderer.close()


def put_together(street: Background, gains: Sequence[float]) -> F32:
    return np.tensordot(np.array(gains, np.float32), street.pixels, axes=1)


@pytest.mark.parametrize("mains", [None, MAINS])
@pytest.mark.parametrize("rectangle", [WHOLE, PART])
def test_the_parts_make_the_whole(
    world: World, mains: FlickeringLamps | None, rectangle: tuple[int, int, int, int]
) -> None:
    street = world.street(mains, rectangle)
    parts = 3 if mains is None else 4
    assert street.pixels.shape == (parts, 48, 64)
    assert street.points.shape == (96, 128, parts)
    np.testing.assert_allclose(street.pixels.sum(axis=0), world.drawn(), rtol=1e-4)
    outside = np.ones((48, 64), bool)
    x0, y0, x1, y1 = rectangle
    outside[max(y0 - 1, 0) : y1 + 1, max(x0 - 1, 0) : x1 + 1] = False
    assert (street.pixels[1:3, outside] == 0).all()


@pytest.mark.parametrize(("part", "light"), [(1, SUN), (2, LAMP)])
@pytest.mark.parametrize("gain", [0.0, 0.4, 1.5])
def test_a_light_turned_down_is_its_part_turned_down(
    world: World, part: int, light: int, gain: float
) -> None:
    gains = np.ones(3)
    gains[part] = gain
    street = world.street(None)
    with changed_lights(world.model, {light: gain * world.model.light_intensity[light]}):
        wanted = world.drawn()
    np.testing.assert_allclose(put_together(street, list(gains)), wanted, rtol=2e-3)
    assert street.pixels[part].max() > 10
    assert street.pixels[part].min() < 1e-3 * street.pixels[part].max()  # its shadow


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.5])
@pytest.mark.parametrize("rectangle", [WHOLE, PART])
def test_mains_swing_as_drawn(
    world: World, factor: float, rectangle: tuple[int, int, int, int]
) -> None:
    """The lamp that is on the mains and casts shadows is a part of its own within the rectangle."""
    street = world.street(MAINS, rectangle)
    with MAINS.scaled(world.model, factor):
        wanted = world.drawn()
    image = put_together(street, [1.0, 1.0, factor, factor])
    np.testing.assert_allclose(image, wanted, rtol=2e-3)
    assert np.abs(image - put_together(street, [1.0] * 4)).max() > 0.2 * wanted.max()


def test_the_model_is_put_back(world: World) -> None:
    before = world.model.light_intensity.copy(), world.model.mat_emission.copy()
    world.street(MAINS)
    np.testing.assert_array_equal(world.model.light_intensity, before[0])
    np.testing.assert_array_equal(world.model.mat_emission, before[1])


def test_albedo_is_luminance_a_lux(world: World) -> None:
    albedo = to_pixels(world.street(None, PART).albedo_points, SIZE)
    assert albedo[37, 30] == pytest.approx(0.5 / np.pi, rel=0.05)
    assert albedo[26, 41] == pytest.approx(0.1 / np.pi, rel=0.25)  # glass, without its own light
    assert (albedo[:6] == 0).all()


def test_shape_is_that_of_the_ground(world: World) -> None:
    """Below the horizon at row 24, the ground is height · focal / (row - 24) away."""
    street = world.street(None)
    np.testing.assert_allclose(street.depth[44], 1.2 * 50 / 20.5, rtol=1e-5)
    np.testing.assert_allclose(street.nearness[89], 20.75 / (1.2 * 50), rtol=1e-5)
    np.testing.assert_allclose(street.normals[44], np.tile([0, -1, 0], (64, 1)), atol=1e-6)
    assert (street.depth[2, 60:] > 1e5).all()
    assert (street.normals[2, 60:] == 0).all()


def test_composed_without_movers_it_is_the_street_drawn(world: World) -> None:
    image = composed(world.street(MAINS), lights(1.0, 1.0, 1.0, 1.0), lens=LENS)
    np.testing.assert_allclose(image, world.drawn(), rtol=1e-4)
