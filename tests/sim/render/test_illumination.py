"""Sky and sun of an illumination, and what a model looks like in it."""

from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim import Illumination, PhotometricCamera
from sim.errors import SceneConfigError
from sim.render.illumination import ILLUMINATIONS, named_illumination

FLOOR = """<mujoco>
  <custom><text name="filament.material.base_color_type" data="linear"/>{custom}</custom>
  <asset>
    <texture type="skybox" builtin="gradient" rgb1=".3 .5 .7" rgb2="0 0 0" width="32" height="192"/>
    <material name="grey" rgba=".5 .5 .5 1" metallic="0" roughness="1"/>
    <material name="glow" rgba="0 0 0 1" metallic="0" roughness="1" emission="1"/>
  </asset>
  <worldbody>
    <light pos="0 0 3" dir="0 0 -1"/>{lights}
    <camera name="down" pos="0 0 3" fovy="40"/>
    <camera name="level" pos="0 -5 1" xyaxes="1 0 0 0 0 1" fovy="40"/>
    <geom type="plane" size="20 20 1" material="grey"/>{more}
  </worldbody>
</mujoco>"""


def luminance(
    light: Any, camera: str = "down", *, more: str = "", lights: str = "", custom: str = ""
) -> npt.NDArray[np.float32]:
    model = mujoco.MjModel.from_xml_string(FLOOR.format(more=more, lights=lights, custom=custom))
    size: dict[str, Any] = {"width": 48, "height": 36, "still": True}
    with PhotometricCamera(model, camera, light=light, **size) as eye:
        return eye.luminance(mujoco.MjData(model))


@pytest.mark.parametrize("name", ILLUMINATIONS)
def test_a_floor_and_the_sky_have_the_stated_luminance(name: str) -> None:
    light = ILLUMINATIONS[name]
    # Every dielectric also has a faint gloss, which reflects a few per cent.
    assert 1 <= luminance(name).mean() / (0.5 * light.lux / np.pi) < 1.035
    assert luminance(name, "level")[0] == pytest.approx(light.sky_lux / np.pi, rel=1e-3)


def test_it_replaces_the_models_lights_and_rendering_options() -> None:
    """Another photometric lamp, and the ambient occlusion that is on by default, have no effect."""
    lamp = '<light type="spot" pos="0 0 2" dir="0 0 -1" intensity="9000" diffuse="1 1 1"/>'
    wall = '<geom type="box" size="1 .1 1" pos="0 .5 0" material="grey"/>'
    off = '<numeric name="filament.ao.enabled" data="0"/>'
    plain = luminance("overcast", more=wall, custom=off)
    np.testing.assert_array_equal(luminance("overcast", more=wall, lights=lamp), plain)


def test_the_sun_casts_shadows_away_from_itself() -> None:
    """A sun in the world's x shades the floor on the side of -x, to the left in the image."""
    sun = Illumination(sky_lux=1000, sun_lux=9000, sun_azimuth_deg=90, sun_elevation_deg=45)
    pole = '<geom type="box" size=".05 2 .4" pos="0 0 .4" material="grey"/>'
    row = luminance(sun, more=pole)[18]
    shaded = row < 0.3 * row.max()
    assert shaded[12:20].sum() >= 5
    assert not shaded[28:].any()
    assert row[15] == pytest.approx(0.5 * 1000 / np.pi, rel=0.1)


def test_emission_is_relative_to_a_white_surface_in_the_same_light() -> None:
    glow = '<geom type="box" size="9 9 .1" material="glow"/>'
    for name in ("daylight", "indoor"):
        white = ILLUMINATIONS[name].lux / np.pi
        assert luminance(name, more=glow).mean() == pytest.approx(white, rel=0.05)


def test_errors_say_what_is_allowed() -> None:
    assert named_illumination("night").lux == pytest.approx(10)
    with pytest.raises(SceneConfigError, match=r"no light 'noon'\. Allowed are 'daylight', 'over"):
        named_illumination("noon")
    with pytest.raises(SceneConfigError, match="sky_lux is 0 and sun_lux is 0"):
        Illumination(sky_lux=0, sun_lux=0)
    with pytest.raises(SceneConfigError, match="sky_lux is nan"):
        Illumination(sky_lux=float("nan"))
    with pytest.raises(SceneConfigError, match="elevation from 5° to 90°"):
        Illumination(sky_lux=1, sun_lux=1, sun_elevation_deg=0)
