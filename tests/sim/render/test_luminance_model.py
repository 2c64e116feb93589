"""Conversion of all colours of a model to greys of the same luminance."""

import mujoco
import numpy as np
import pytest

from sim.render.luminance_model import luminance_model
from sim.scene import srgb
from sim.scene.lighting import LUMINANCE_OF_RGB

RGB = np.array([0.2, 0.7, 0.4])


def model_of(text: str = "", texture: str = "") -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(f"""
    <mujoco>
      {text}
      <asset>
        <texture name="t" type="2d" builtin="flat" rgb1=".2 .7 .4" width="2" height="2" {texture}/>
        <material name="m" rgba=".2 .7 .4 .3" texture="t"/>
      </asset>
      <worldbody>
        <light diffuse=".2 .7 .4"/><geom size="1" rgba=".2 .7 .4 .3"/>
      </worldbody>
    </mujoco>""")


def srgb_grey() -> float:
    return float(srgb.encoded(srgb.decoded(RGB) @ LUMINANCE_OF_RGB))


def test_colours_of_materials_and_geoms_are_srgb_by_default() -> None:
    grey = luminance_model(model_of())
    for rgba in (grey.mat_rgba[0], grey.geom_rgba[0]):
        assert rgba == pytest.approx([*[srgb_grey()] * 3, 0.3], abs=1e-6)


def test_a_model_may_declare_its_colours_linear() -> None:
    linear = '<custom><text name="filament.material.base_color_type" data="linear"/></custom>'
    grey = luminance_model(model_of(linear))
    assert grey.mat_rgba[0, :3] == pytest.approx([float(RGB @ LUMINANCE_OF_RGB)] * 3, abs=1e-6)


@pytest.mark.parametrize(
    ("space", "expected"), [("linear", float(RGB @ LUMINANCE_OF_RGB)), ("sRGB", srgb_grey())]
)
def test_a_texture_is_read_in_its_colour_space(space: str, expected: float) -> None:
    grey = luminance_model(model_of(texture=f'colorspace="{space}"'))
    assert grey.tex_data == pytest.approx(255 * expected, abs=1.5)
    assert len(np.unique(grey.tex_data)) == 1


def test_lights_are_linear_and_the_original_model_is_not_changed() -> None:
    model = model_of()
    grey = luminance_model(model)
    assert grey.light_diffuse[0] == pytest.approx([float(RGB @ LUMINANCE_OF_RGB)] * 3, abs=1e-6)
    assert model.light_diffuse[0] == pytest.approx(RGB)
    assert model.mat_rgba[0, :3] == pytest.approx(RGB)
    assert len(np.unique(model.tex_data)) == 3
