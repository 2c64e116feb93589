"""Beams and shadows of a model, held against closed forms and against the renderer's own."""

import math

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim.errors import SceneConfigError
from sim.geometry.pinhole import Intrinsics
from sim.geometry.rigid_transform import body_poses
from sim.raster.aperture import LENS_BLUR_PX, to_pixels
from sim.raster.triangles import triangle_soup
from sim.render.filament import FilamentRenderer
from sim.render.luminance_model import luminance_model
from sim.scene.moving_objects import moving_object
from sim.shadows.moving_light import LightReach, MovingLight
from tests.sim.flat import above, composed, flat_street

F32 = npt.NDArray[np.float32]

LENS = Intrinsics(width=64, height=48, focal_px=40.0)
EYE_M, LAMP_M, CANDELA, CUTOFF_DEG, ALBEDO = 3.0, 2.0, 5000.0, 40.0, 0.2


def lamp_over_a_plane(direction: str, softness: float = 0.5) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(f"""<mujoco>
      <custom>
        <text name="filament.material.base_color_type" data="linear"/>
        <numeric name="filament.ao.enabled" data="0"/>
      </custom>
      <asset><material name="white" rgba="1 1 1 1" metallic="0" roughness="1"/></asset>
      <worldbody>
        <geom type="plane" size="50 50 .1" material="white"/>
        <body pos="-.3 .2 {LAMP_M}">
          <joint/><geom size=".01" mass="1" pos="0 0 2"/>
          <light type="spot" dir="{direction}" cutoff="{CUTOFF_DEG}" softness="{softness}"
            intensity="{CANDELA}" diffuse="1 1 1" range="60" castshadow="false"/>
        </body>
      </worldbody>
    </mujoco>""")


def placed(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    return data


def beam(
    model: mujoco.MjModel,
    lens: Intrinsics = LENS,
    size: int = 3,
    blur_px: float = LENS_BLUR_PX,
) -> F32:
    """Illuminance of the plane as the engine has it [lux]."""
    data, pose = placed(model), above(EYE_M)
    obj = moving_object(model, "lamp", "box", 1)
    reach = LightReach(model, data, (obj,), pose, lens)
    moving = MovingLight(model, triangle_soup(model).of_bodies(obj.bodies), reach)
    light = moving.lights(data, body_poses(data), reach.at(data), np.ones(1))
    street = flat_street(EYE_M, np.zeros(1), albedo=ALBEDO, lens=lens, size=size)
    return composed(street, light, lens=lens, blur_px=blur_px) / np.float32(ALBEDO)


def drawn(model: mujoco.MjModel) -> F32:
    """The same as the renderer has it; a white plane's luminance times π [lux]."""
    with FilamentRenderer(luminance_model(model), LENS) as renderer:
        renderer.update(placed(model))
        whole = (0, 0, LENS.width, LENS.height)
        return renderer.luminance(above(EYE_M), whole, supersample=3) * np.float32(math.pi)


def off_axis(model: mujoco.MjModel) -> tuple[npt.NDArray[np.float64], ...]:
    """Angle to the beam's axis [deg], and the lux of a lamp that is as bright in all directions."""
    x, y = np.meshgrid(np.arange(64) + 0.5 - 32, np.arange(48) + 0.5 - 24)
    scale = EYE_M / LENS.focal_px
    way = np.stack([x * scale + 0.3, -y * scale - 0.2, np.full(x.shape, -LAMP_M)], axis=-1)
    cosine = way @ placed(model).light_xdir[0] / np.linalg.norm(way, axis=-1)
    to_normal = LAMP_M / np.linalg.norm(way, axis=-1)
    return np.degrees(np.arccos(cosine)), CANDELA * to_normal**3 / LAMP_M**2


@pytest.mark.parametrize("direction", ["0 0 -1", ".5 -.3 -1"])
def test_within_the_cone_a_beam_gives_candela_by_cosine_cubed_by_height_squared(
    direction: str,
) -> None:
    model = lamp_over_a_plane(direction)
    lux, (angle_deg, wanted) = beam(model), off_axis(model)
    full = angle_deg < 0.5 * CUTOFF_DEG - 1.5
    assert full.sum() > 100
    np.testing.assert_allclose(lux[full], wanted[full], rtol=2e-3)
    assert (lux[angle_deg > CUTOFF_DEG + 4] == 0).all()
    rim = (angle_deg > 0.5 * CUTOFF_DEG + 2) & (angle_deg < CUTOFF_DEG - 1)
    assert (lux[rim] < 0.99 * wanted[rim]).all()
    assert (lux[rim] > 0).all()


@pytest.mark.parametrize("softness", [0.5, 0.8])
def test_a_beam_is_as_the_renderer_draws_it(softness: float) -> None:
    model = lamp_over_a_plane(".5 -.3 -1", softness)
    lux, reference, (angle_deg, _) = beam(model), drawn(model), off_axis(model)
    bright = (reference > 0.02 * reference.max()) & (angle_deg < 0.85 * CUTOFF_DEG)
    assert angle_deg[bright].max() > 0.84 * CUTOFF_DEG
    np.testing.assert_allclose(lux[bright], reference[bright], rtol=0.03)
    # Nearer to the rim, the renderer's cosine of the cone, which is off by 1e-3, tells.
    assert np.abs(lux - reference).max() < 0.012 * reference.max()


def test_a_sharp_rim_is_seen_through_the_aperture() -> None:
    model = lamp_over_a_plane(".5 -.3 -1", softness=0.01)
    fine = beam(model, LENS.scaled(3), size=1, blur_px=0.0)
    inner = np.s_[1:-1, 1:-1]
    wanted = to_pixels(fine, 3)[inner]
    np.testing.assert_allclose(beam(model)[inner], wanted, rtol=1e-4, atol=5e-4 * wanted.max())


STREET = """<mujoco><worldbody>
  <geom type="plane" size="50 50 .1"/>
  <light name="sun" type="directional" dir=".4 .3 -1" intensity="1" castshadow="true"/>
  <light name="weak" type="spot" pos="1 1 3" intensity="1" castshadow="false"/>
  <light name="off" type="spot" pos="1 1 3" intensity="0" castshadow="true"/>
  <light name="lamp" type="spot" pos="-1 1 3" dir="0 0 -1" intensity="1" castshadow="true"/>
  {movers}
</worldbody></mujoco>"""
MOVER = """<body pos="{x} 0 .5"><freejoint/><geom type="box" size=".1 .1 .1"/>
  <geom type="box" size=".1 .1 .1" pos="0 .4 0" group="2"/>
  <light type="spot" dir="1 0 -.6" cutoff="20" intensity="1" castshadow="true"/></body>"""


def street_of(count: int) -> tuple[mujoco.MjModel, mujoco.MjData, LightReach]:
    movers = "".join(MOVER.format(x=0.3 * k) for k in range(count))
    model = mujoco.MjModel.from_xml_string(STREET.format(movers=movers))
    data = placed(model)
    objects = tuple(moving_object(model, f"it_{k}", "box", k + 1) for k in range(count))
    return model, data, LightReach(model, data, objects, above(EYE_M), LENS)


def test_still_lights_that_shine_and_cast_shadows_are_taken_apart() -> None:
    model, data, reach = street_of(2)
    assert [model.light(int(k)).name for k in reach.shadowing] == ["sun", "lamp"]
    assert [lamp.parallel for lamp in reach.lamps] == [True, False]
    assert len(reach.beams) == 2
    now = reach.at(data)
    assert [(k, obj.name) for k, obj, _ in now.shadows] == [
        (k, name) for name in ("it_0", "it_1") for k in (0, 1)
    ]
    assert len(now.rectangles) == len(now.shadows) + len(now.beams)


def test_geoms_that_cast_no_shadow_in_the_renderer_cast_none_here() -> None:
    model, data, reach = street_of(1)
    moving = MovingLight(model, triangle_soup(model).of_bodies([1]), reach)
    light = moving.lights(data, body_poses(data), reach.at(data), np.ones(3))
    street = flat_street(EYE_M, np.array([0.0, 1.0, 0.0]), lens=LENS)
    lit = composed(street, light._replace(beams=light.beams[:0]), lens=LENS)
    y, _ = np.nonzero(lit < 0.5)
    # The box's shadow is 0.35 m long, from 0.05 m before the middle; the other's would be at 0.4.
    assert (24 - y).max() * EYE_M / LENS.focal_px < 0.4
    assert y.size > 10


def test_an_object_far_away_changes_nothing() -> None:
    model, data, reach = street_of(1)
    data.qpos[:] = [60, 0, 0.5, 1, 0, 0, 0]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    assert reach.at(data).rectangles == []


def test_more_shadows_than_can_be_told_apart_are_refused() -> None:
    model, _, reach = street_of(15)
    with pytest.raises(SceneConfigError, match=r"15 moving objects before 2 lights make 30 .*29"):
        MovingLight(model, triangle_soup(model).of_bodies(np.arange(1, 16)), reach)
