"""The surface that is seen where several have the same depth. These tests need a Vulkan device."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest

from sim.geometry.pinhole import Intrinsics, Pose
from sim.render.draw_order import MAX_STATES
from sim.render.filament import FilamentRenderer
from sim.scene import lighting

COUNT = 24
BRIGHTEST_CD_M2 = 100.0
GLOSS = 0.011
"""Share of the light that Filament's matt surface reflects without its colour (measured)."""
LENS = Intrinsics(width=8, height=6, focal_px=8.0)
WHOLE = (0, 0, LENS.width, LENS.height)
ABOVE = Pose(np.array([0.0, 0.0, 3.0]), up=np.array([0.0, 1.0, 0.0]))


BOX = '<geom type="box" size="9 9 .1" material="m{0}"/>'
CLOTH = """<flexcomp name="f{0}" type="grid" dim="2" count="2 2 1" spacing="9 9 1" mass="1"
material="m{0}"><edge equality="true"/></flexcomp>"""
SITE = '<site type="box" size="9 9 .1" material="m{0}"/>'


def grey(number: float) -> float:
    """Return the reflectance of a slab."""
    return (number + 1) / BRIGHTEST_CD_M2


def coinciding_slabs(shape: str) -> Any:
    """Return a model of slabs in the same place. Number k has a luminance of k + 1 [cd/m²]."""
    numbers = range(COUNT)
    matte = 'metallic="0" roughness="1"'
    materials = "".join(
        f'<material name="m{k}" rgba="{grey(k)} {grey(k)} {grey(k)} 1" {matte}/>' for k in numbers
    )
    slabs = "".join(shape.format(k) for k in numbers)
    spec = mujoco.MjSpec.from_string(f"""
    <mujoco>
      <custom><text name="filament.material.base_color_type" data="linear"/></custom>
      <asset>{materials}</asset><worldbody>{slabs}</worldbody>
    </mujoco>""")
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        dir=[0, 0, -1],
        diffuse=lighting.WHITE,
        intensity=math.pi * BRIGHTEST_CD_M2,
    )
    return spec.compile()


class Scene:
    """A renderer of the slabs."""

    def __init__(self, shape: str) -> None:
        self.model = coinciding_slabs(shape)
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)
        self.renderer = FilamentRenderer(self.model, LENS)

    def seen(self) -> float:
        """Return the luminance in the image, without that of the gloss [cd/m²]."""
        self.renderer.update(self.data)
        image = self.renderer.subpixel_luminance(ABOVE, WHOLE, 1)
        assert np.ptp(image) < 0.1  # all pixels show the same slab
        return float(np.median(image)) - GLOSS * BRIGHTEST_CD_M2


@pytest.fixture
def scene() -> Any:
    scene = Scene(BOX)
    with scene.renderer:
        yield scene


@pytest.mark.parametrize("shape", [BOX, SITE, CLOTH])
def test_of_coinciding_surfaces_the_last_is_seen(shape: str) -> None:
    scene = Scene(shape)
    with scene.renderer:
        assert scene.seen() == pytest.approx(COUNT, abs=0.3)


def test_hiding_and_showing_surfaces_does_not_change_their_order(scene: Scene) -> None:
    before = scene.seen()
    with scene.renderer.hidden(range(5, COUNT)):
        assert scene.seen() == pytest.approx(5, abs=0.3)
    assert scene.seen() == pytest.approx(before)
    with scene.renderer.hidden(range(COUNT)):
        assert scene.seen() < 0
    assert scene.seen() == pytest.approx(before)


def test_materials_that_change_are_drawn_in_the_order_of_the_model(scene: Scene) -> None:
    reflectance = scene.model.mat_rgba[:, :3].copy()
    for factor in (1.0, 2.0, 3.0, 1.0):
        scene.model.mat_rgba[:, :3] = factor * reflectance
        assert scene.seen() == pytest.approx(factor * COUNT, abs=0.3)


def test_more_changes_than_are_kept_are_drawn_in_the_order_of_the_model(scene: Scene) -> None:
    reflectance = scene.model.mat_rgba[:, :3].copy()
    for factor in np.linspace(1.0, 4.0, 3 * MAX_STATES):
        scene.model.mat_rgba[:, :3] = factor * reflectance
        assert scene.seen() == pytest.approx(factor * COUNT, abs=0.3)


def test_changes_without_images_in_between_are_allowed(scene: Scene) -> None:
    reflectance = scene.model.mat_rgba[:, :3].copy()
    assert scene.seen() == pytest.approx(COUNT, abs=0.3)
    for factor in np.linspace(1.0, 4.0, 3 * MAX_STATES):
        scene.model.mat_rgba[:, :3] = factor * reflectance
        scene.renderer.update(scene.data)
    assert scene.seen() == pytest.approx(4.0 * COUNT, abs=0.3)
