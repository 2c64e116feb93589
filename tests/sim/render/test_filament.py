"""Luminance from the renderer, compared with closed forms. These tests need a Vulkan device."""

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from sim.geometry.pinhole import Intrinsics, Pose
from sim.render.filament import FilamentRenderer
from sim.render.luminance_model import luminance_model
from sim.render.vulkan import vulkan_devices
from sim.scene import lighting

LENS = Intrinsics(width=64, height=48, focal_px=60.0)
WHOLE = (0, 0, LENS.width, LENS.height)
ABOVE = Pose(np.array([0.0, 0.0, 3.0]), up=np.array([0.0, 1.0, 0.0]))
SUN = lighting.sun_direction(-150, 48)
MATTE = 'metallic="0" roughness="1"'


def white_plane(
    add_light: Callable[[mujoco.MjSpec], None], *, assets: str = "", geoms: str = ""
) -> Any:
    spec = mujoco.MjSpec.from_string(f"""
    <mujoco>
      <custom>
        <text name="filament.material.base_color_type" data="linear"/>
        <numeric name="filament.ao.enabled" data="0"/>
      </custom>
      <asset><material name="white" rgba="1 1 1 1" {MATTE}/>{assets}</asset>
      <worldbody><geom type="plane" size="50 50 .1" material="white"/>{geoms}</worldbody>
    </mujoco>""")
    add_light(spec)
    return spec.compile()


def render(model: Any, *, supersample: int = 1) -> Any:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with FilamentRenderer(luminance_model(model), LENS) as renderer:
        renderer.update(data)
        return renderer.luminance(ABOVE, WHOLE, supersample=supersample)


def sun(spec: mujoco.MjSpec, lux: float) -> None:
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        dir=[0, 0, -1],
        diffuse=lighting.WHITE,
        intensity=lux,
    )


@pytest.mark.parametrize("lux", [0.1, 10.0, 100_000.0])
def test_a_white_lambertian_plane_reads_illuminance_over_pi(lux: float) -> None:
    image = render(white_plane(lambda spec: sun(spec, lux)))
    assert image.dtype == np.float32
    assert image.shape == (48, 64)
    assert image * np.pi == pytest.approx(lux, rel=0.03)


@pytest.mark.parametrize("lux", [0.1, 10.0, 100_000.0])
def test_sun_and_sky_together_give_the_configured_illuminance(lux: float) -> None:
    image = render(white_plane(lambda spec: lighting.add_day(spec, lux, SUN)))
    assert np.median(image) * np.pi == pytest.approx(lux, rel=0.03)


@pytest.mark.parametrize("lux", [0.1, 10.0, 100.0])
def test_street_lamps_give_the_configured_illuminance_at_the_origin(lux: float) -> None:
    lamps = np.array([[2.6, 6.4, 5.85], [-6.0, -4.0, 5.85], [6.0, -4.0, 5.85]])
    image = render(white_plane(lambda spec: lighting.add_night(spec, lux, lamps)))
    assert image[24, 32] * np.pi == pytest.approx(lux, rel=0.05)


def test_a_lamp_lens_has_the_luminance_that_was_set() -> None:
    def lamp(spec: mujoco.MjSpec) -> None:
        sun(spec, 1e-3)
        lighting.set_luminance(spec.material("lens"), 400.0, lighting.TAIL_LAMP_RGB)

    red = f"""<texture name="glow" type="2d" builtin="flat" rgb1="1 .1 .05" width="4" height="4"/>
      <material name="lens" rgba=".5 .03 .02 1" {MATTE}>
        <layer role="emissive" texture="glow"/>
      </material>"""
    box = '<geom type="box" size="9 9 .01" pos="0 0 .01" material="lens"/>'
    assert render(white_plane(lamp, assets=red, geoms=box)) == pytest.approx(400, rel=0.03)


def test_a_dipped_beam_lights_a_wall_up_to_the_height_of_the_lamp_and_no_higher() -> None:
    """One lamp 10 m from a white wall: E = I cos³θ / d² on the beam's axis, and no light above."""
    spec = mujoco.MjSpec.from_string(f"""
    <mujoco>
      <custom><numeric name="filament.ao.enabled" data="0"/></custom>
      <asset><material name="white" rgba="1 1 1 1" {MATTE}/></asset>
      <worldbody>
        <geom type="box" size=".1 20 20" pos="10.1 0 0" material="white"/><body name="car"/>
      </worldbody>
    </mujoco>""")
    lighting.add_head_lamps(spec.body("car"), np.array([[0.0, 0.0, 0.66]]))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pose = Pose(np.array([0.0, 0.0, 0.66]), right=np.array([0.0, -1.0, 0.0]))
    with FilamentRenderer(luminance_model(model), LENS) as renderer:
        renderer.update(data)
        image = renderer.luminance(pose, WHOLE)
    assert image[:23].max() < 1e-3
    row = 24 + round(LENS.focal_px * lighting.BEAM_CENTRE_DIP)
    cosine = np.cos(np.arctan(lighting.BEAM_CENTRE_DIP))
    hot_lux = lighting.BEAM_CENTRE_CD * cosine**3 / 10**2
    spread_lux = lighting.BEAM_WIDE_CD / 10**2
    assert 0.95 * hot_lux < image[row, 32] * np.pi < 1.02 * (hot_lux + spread_lux)
    assert image[row, 2] * np.pi < 0.1 * spread_lux


def test_a_coloured_surface_reflects_its_relative_luminance() -> None:
    green = f'<material name="green" rgba="0 .5 0 1" {MATTE}/>'
    box = '<geom type="box" size="9 9 .01" pos="0 0 .01" material="green"/>'
    image = render(white_plane(lambda spec: sun(spec, 1000), assets=green, geoms=box))
    # Filament adds the faint gloss of every dielectric, here 3 %.
    assert image * np.pi == pytest.approx(1000 * 0.5 * 0.7152, rel=0.04)


def test_pixels_on_an_edge_are_weighted_by_area() -> None:
    black = f'<material name="black" rgba="0 0 0 1" {MATTE}/>'
    box = '<geom type="box" size="5 5 .0001" pos="-5.005 0 0" euler="0 0 8" material="black"/>'
    model = white_plane(lambda spec: sun(spec, 1000), assets=black, geoms=box)
    image = render(model, supersample=4)
    levels = np.unique(np.round(image / image.max(), 2))
    assert levels.size > 20
    profile = image[24] / image.max()
    assert (np.diff(profile) >= -0.02).all()


def test_rendering_a_frame_twice_gives_equal_images() -> None:
    model = white_plane(lambda spec: lighting.add_day(spec, 1000, SUN))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with FilamentRenderer(luminance_model(model), LENS) as renderer:
        renderer.update(data)
        first = renderer.luminance(ABOVE, WHOLE)
        assert np.array_equal(first, renderer.luminance(ABOVE, WHOLE))


def test_every_vulkan_device_has_a_name_and_a_driver() -> None:
    devices = vulkan_devices()
    assert devices
    assert all(device.name and len(device.driver) > 4 for device in devices)
