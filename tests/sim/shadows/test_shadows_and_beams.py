"""Beams and shadows of a model, compared with closed forms and with the renderer's."""

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
from sim.shadows.shadows_and_beams import AffectedAreaFinder, ShadowBeamRenderer
from tests.sim.flat_background import composited, flat_background, pose_above

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


def beam_lux(
    model: mujoco.MjModel,
    lens: Intrinsics = LENS,
    supersample: int = 3,
    blur_px: float = LENS_BLUR_PX,
) -> F32:
    """Return the illuminance of the plane as compositing computes it [lux]."""
    data, pose = placed(model), pose_above(EYE_M)
    obj = moving_object(model, "lamp", "box", 1)
    finder = AffectedAreaFinder(model, data, (obj,), pose, lens)
    movers = triangle_soup(model).of_bodies(obj.bodies)
    effects = ShadowBeamRenderer(model, movers, finder).render(
        body_poses(data), finder.find(data), np.ones(1)
    )
    background = flat_background(
        EYE_M, np.zeros(1), albedo=ALBEDO, lens=lens, supersample=supersample
    )
    return composited(background, effects, lens=lens, blur_px=blur_px) / np.float32(ALBEDO)


def rendered_lux(model: mujoco.MjModel) -> F32:
    """Return the illuminance from the renderer: a white plane's luminance times π [lux]."""
    with FilamentRenderer(luminance_model(model), LENS) as renderer:
        renderer.update(placed(model))
        whole = (0, 0, LENS.width, LENS.height)
        return renderer.luminance(pose_above(EYE_M), whole, supersample=3) * np.float32(math.pi)


def off_axis(model: mujoco.MjModel) -> tuple[npt.NDArray[np.float64], ...]:
    """Return the angle to the beam's axis [deg], and the lux of an isotropic lamp."""
    x, y = np.meshgrid(np.arange(64) + 0.5 - 32, np.arange(48) + 0.5 - 24)
    scale = EYE_M / LENS.focal_px
    ray = np.stack([x * scale + 0.3, -y * scale - 0.2, np.full(x.shape, -LAMP_M)], axis=-1)
    cosine = ray @ placed(model).light_xdir[0] / np.linalg.norm(ray, axis=-1)
    to_normal = LAMP_M / np.linalg.norm(ray, axis=-1)
    return np.degrees(np.arccos(cosine)), CANDELA * to_normal**3 / LAMP_M**2


@pytest.mark.parametrize("direction", ["0 0 -1", ".5 -.3 -1"])
def test_within_the_cone_lux_is_candela_times_cosine_cubed_over_height_squared(
    direction: str,
) -> None:
    model = lamp_over_a_plane(direction)
    lux, (angle_deg, wanted) = beam_lux(model), off_axis(model)
    full = angle_deg < 0.5 * CUTOFF_DEG - 1.5
    assert full.sum() > 100
    np.testing.assert_allclose(lux[full], wanted[full], rtol=2e-3)
    assert (lux[angle_deg > CUTOFF_DEG + 4] == 0).all()
    rim = (angle_deg > 0.5 * CUTOFF_DEG + 2) & (angle_deg < CUTOFF_DEG - 1)
    assert (lux[rim] < 0.99 * wanted[rim]).all()
    assert (lux[rim] > 0).all()


@pytest.mark.parametrize("softness", [0.5, 0.8])
def test_a_beam_agrees_with_the_renderer(softness: float) -> None:
    model = lamp_over_a_plane(".5 -.3 -1", softness)
    lux, reference, (angle_deg, _) = beam_lux(model), rendered_lux(model), off_axis(model)
    bright = (reference > 0.02 * reference.max()) & (angle_deg < 0.85 * CUTOFF_DEG)
    assert angle_deg[bright].max() > 0.84 * CUTOFF_DEG
    np.testing.assert_allclose(lux[bright], reference[bright], rtol=0.03)
    # Near the rim, the error of 1e-3 in the renderer's cosine of the cone becomes visible.
    assert np.abs(lux - reference).max() < 0.012 * reference.max()


def test_a_sharp_rim_is_weighted_with_the_aperture() -> None:
    model = lamp_over_a_plane(".5 -.3 -1", softness=0.01)
    fine = beam_lux(model, LENS.scaled(3), supersample=1, blur_px=0.0)
    inner = np.s_[1:-1, 1:-1]
    wanted = to_pixels(fine, 3)[inner]
    np.testing.assert_allclose(beam_lux(model)[inner], wanted, rtol=1e-4, atol=5e-4 * wanted.max())


STREET = """<mujoco><worldbody>
  <geom type="plane" size="50 50 .1"/>
  <light name="sun" type="directional" dir=".4 .3 -1" intensity="1" castshadow="true"/>
  <light name="weak" type="spot" pos="1 1 3" intensity="1" castshadow="false"/>
  <light name="off" type="spot" pos="1 1 3" intensity="0" castshadow="true"/>
  <light name="lamp" type="spot" pos="-1 1 3" dir="0 0 -1" intensity="1" castshadow="true"/>
  {movers}
</worldbody></mujoco>"""
MOVER = """<body pos="{x} 0 .5"><freejoint/><geom type="box" size=".1 .1 .1"/>
  <geom type="box" size=".1 .1 .1" pos="0 .4 0" castshadow="false"/>
  <light type="spot" dir="1 0 -.6" cutoff="20" intensity="1" castshadow="true"/></body>"""


def street_with_movers(
    count: int,
) -> tuple[mujoco.MjModel, mujoco.MjData, AffectedAreaFinder]:
    movers = "".join(MOVER.format(x=0.3 * k) for k in range(count))
    model = mujoco.MjModel.from_xml_string(STREET.format(movers=movers))
    data = placed(model)
    objects = tuple(moving_object(model, f"mover_{k}", "box", k + 1) for k in range(count))
    return model, data, AffectedAreaFinder(model, data, objects, pose_above(EYE_M), LENS)


def test_each_mover_has_a_shadow_for_each_fixed_light_that_casts_shadows() -> None:
    model, data, finder = street_with_movers(2)
    assert [model.light(int(k)).name for k in finder.shadow_lights] == ["sun", "lamp"]
    assert [source.is_sun for source in finder.sources] == [True, False]
    assert len(finder.beams) == 2
    areas = finder.find(data)
    assert areas.shadows.shape == (2, 2, 4)
    assert areas.beam_areas.shape == (2, 4)
    assert areas.rectangles == [
        *map(tuple, areas.shadows.reshape(-1, 4)),
        *map(tuple, areas.beam_areas),
    ]
    effects = ShadowBeamRenderer(model, triangle_soup(model).of_bodies([1, 2]), finder).render(
        body_poses(data), areas, np.ones(3)
    )
    assert effects.light.tolist() == [0, 1, 0, 1]
    assert effects.is_sun.tolist() == [True, False, True, False]
    np.testing.assert_array_equal(effects.shadow_areas, areas.shadows.reshape(-1, 4))
    np.testing.assert_array_equal(effects.beam_areas, areas.beam_areas)


def test_what_is_out_of_view_has_no_shadow_map_and_no_beam() -> None:
    """The objects and lamps in view keep theirs, in their order."""
    model, data, finder = street_with_movers(3)
    data.qpos[7:10] = [60, 0, 0.5]  # of the second
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    areas = finder.find(data)
    assert areas.shadows.any(axis=-1).tolist() == [[True, True], [False, False], [True, True]]
    effects = ShadowBeamRenderer(model, triangle_soup(model).of_bodies([1, 2, 3]), finder).render(
        body_poses(data), areas, np.ones(3)
    )
    np.testing.assert_array_equal(effects.shadow_areas, areas.shadows[[0, 2]].reshape(-1, 4))
    into = finder.pose.world_to_camera
    tips = data.light_xpos[finder.beams[[0, 2]]] @ into[:, :3].T + into[:, 3]
    np.testing.assert_allclose(effects.beams[:, :3], tips, rtol=1e-12)


def test_geoms_that_cast_no_shadow_in_the_renderer_cast_none_here() -> None:
    model, data, finder = street_with_movers(1)
    effects = ShadowBeamRenderer(model, triangle_soup(model).of_bodies([1]), finder).render(
        body_poses(data), finder.find(data), np.ones(3)
    )
    background = flat_background(EYE_M, np.array([0.0, 1.0, 0.0]), lens=LENS)
    lit = composited(background, effects._replace(beams=effects.beams[:0]), lens=LENS)
    y, _ = np.nonzero(lit < 0.5)
    # The first box's shadow is 0.35 m long and starts 0.05 m before the centre. The second box's
    # would start at 0.4 m.
    assert (24 - y).max() * EYE_M / LENS.focal_px < 0.4
    assert y.size > 10


def test_a_distant_object_affects_no_area() -> None:
    model, data, finder = street_with_movers(1)
    data.qpos[:] = [60, 0, 0.5, 1, 0, 0, 0]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    assert finder.find(data).rectangles == []


def test_too_many_shadows_are_refused() -> None:
    model, _, finder = street_with_movers(15)
    with pytest.raises(SceneConfigError, match=r"15 moving objects and 2 lights make 30 .*29"):
        ShadowBeamRenderer(model, triangle_soup(model).of_bodies(np.arange(1, 16)), finder)
