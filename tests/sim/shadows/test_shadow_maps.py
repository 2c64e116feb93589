"""The shadow of a box over level ground lies where the geometry predicts, for the sun and for a
lamp."""

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Intrinsics
from sim.geometry.rigid_transform import body_poses, compose_transforms, inverse_transform
from sim.raster.shared_corners import share_corners
from sim.raster.triangles import triangle_soup
from sim.scene.moving_objects import MovingObject, moving_object
from sim.shadows.shadow_maps import (
    MAP_SIDE,
    TEXEL_M,
    ShadowSource,
    render_shadow_map,
    shadow_sources,
)
from tests.sim.flat_background import composited, effects, flat_background, pose_above

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

HEIGHT_M = 4.0
LENS = Intrinsics(width=200, height=160, focal_px=400.0)
HALF_M = np.array([0.35, 0.25, 0.2])
CENTRE_M = np.array([0.1, -0.05, 0.6])
SUN, LAMP = 0, 1


class World:
    """A box, rotated about the vertical, in the light of the sun and of a lamp beside it."""

    def __init__(self, half_m: F64 = HALF_M, turn_deg: float = 30.0) -> None:
        self.model = mujoco.MjModel.from_xml_string(f"""<mujoco><worldbody>
          <light type="directional" dir=".4 .3 -1" intensity="1"/>
          <light type="spot" pos="-.9 .8 3" dir=".3 -.3 -1" cutoff="80" intensity="1"/>
          <body pos="{_text(CENTRE_M)}" euler="0 0 {turn_deg}">
            <joint/><geom type="box" size="{_text(half_m)}"/>
          </body>
        </worldbody></mujoco>""")
        self.data = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
        self.box: MovingObject = moving_object(self.model, "box", "box", 1)
        self.half_m, self.soup = half_m, triangle_soup(self.model)
        self.shared = share_corners(self.soup)

    def source(self, light: int) -> ShadowSource:
        return shadow_sources(self.model, self.data, np.array([light]))[0]

    def lit(self, light: int, ground_m: float) -> F32:
        """Return the share of a light that ground at some height gets, seen from straight above."""
        maps = np.full((1, MAP_SIDE, MAP_SIDE), np.nan, np.float32)
        poses, source = body_poses(self.data), self.source(light)
        made = render_shadow_map(source, self.box, self.shared, poses, maps[0])
        assert made is not None
        shadow = effects(
            1.0,
            1.0,
            maps=maps,
            sizes=np.array([made.size]),
            views=compose_transforms(
                inverse_transform(pose_above(HEIGHT_M).world_to_camera), made.view
            )[None],
            light=np.array([0]),
            is_sun=np.array([source.is_sun]),
            shadow_areas=np.array([[0, 0, LENS.width, LENS.height]]),
        )
        depth_m = HEIGHT_M - ground_m
        background = flat_background(depth_m, np.array([0.0, 1.0]), lens=LENS, supersample=1)
        return composited(background, shadow, lens=LENS, blur_px=0.0)

    def shaded(self, light: int, ground_m: float, grow_m: float) -> Bools:
        """Return the pixels that the box, enlarged on all sides, shades; computed ray by ray."""
        x, y = np.meshgrid(np.arange(LENS.width) + 0.5, np.arange(LENS.height) + 0.5)
        scale = (HEIGHT_M - ground_m) / LENS.focal_px
        ground = np.stack(
            [
                (x - LENS.width / 2) * scale,
                -(y - LENS.height / 2) * scale,
                np.full(x.shape, ground_m),
            ],
            axis=-1,
        )
        source = self.source(light)
        ray = (
            np.broadcast_to(-source.axes[2] * 99, ground.shape)
            if source.is_sun
            else (source.position_m - ground)
        )
        rotation = self.data.xmat[1].reshape(3, 3)
        start, ray = (ground - CENTRE_M) @ rotation, ray @ rotation
        half = self.half_m + grow_m
        ends = np.stack([(-half - start) / ray, (half - start) / ray])
        first, last = ends.min(axis=0).max(axis=-1), ends.max(axis=0).min(axis=-1)
        return np.asarray((first < last) & (last > 0) & (first < 1))


def _text(numbers: F64) -> str:
    return " ".join(map(str, numbers))


@pytest.fixture(scope="module")
def world() -> World:
    return World()


@pytest.mark.parametrize("light", [SUN, LAMP])
@pytest.mark.parametrize("ground_m", [0.0, 0.3])
def test_a_shadow_ends_where_rays_pass_the_box(world: World, light: int, ground_m: float) -> None:
    lit = world.lit(light, ground_m)
    tolerance_m = 1.5 * TEXEL_M + 0.5 * HEIGHT_M / LENS.focal_px
    inside, outside = (world.shaded(light, ground_m, g) for g in (-tolerance_m, tolerance_m))
    assert inside.sum() > 1000
    assert (lit[inside] == 0).all()
    assert (lit[~outside] == 1).all()
    fringe = outside & ~inside
    assert lit[fringe].mean() == pytest.approx(
        1 - world.shaded(light, ground_m, 0.0)[fringe].mean(), abs=0.03
    )


@pytest.mark.parametrize("light", [SUN, LAMP])
def test_only_points_behind_the_box_are_dark(world: World, light: int) -> None:
    top, bottom = CENTRE_M[2] + HALF_M[2], CENTRE_M[2] - HALF_M[2]
    for above_m in (1.5 * TEXEL_M, 0.5):
        assert (world.lit(light, top + above_m) == 1).all()
    dark = world.shaded(light, bottom - 0.01, -2 * TEXEL_M)
    assert dark.any()
    assert (world.lit(light, bottom - 0.01)[dark] == 0).all()


def test_points_behind_the_lamp_or_outside_the_map_are_lit(world: World) -> None:
    assert (world.lit(LAMP, 3.3) == 1).all()
    assert (world.lit(LAMP, 3.8) == 1).all()
    far = World(np.array([0.1, 0.1, 0.1]))
    assert (far.lit(SUN, 0.0)[:20] == 1).all()


def test_an_object_behind_a_lamp_casts_no_shadow(world: World) -> None:
    down = ShadowSource(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 3.0]), is_sun=False)
    up = ShadowSource(np.eye(3), np.array([0.0, 0.0, 3.0]), is_sun=False)
    out, poses = np.empty((MAP_SIDE, MAP_SIDE), np.float32), body_poses(world.data)
    args = world.box, world.shared, poses, out
    assert render_shadow_map(up, *args) is None
    assert render_shadow_map(down, *args) is not None


@pytest.mark.parametrize("half_m", [0.2, 6.3, 6.54, 7.01, 8.0, 8.03, 20.0])
def test_maps_fit_objects_of_any_size(half_m: float) -> None:
    """A square below a sun in the zenith fills its map, except for the margin."""
    world = World(np.array([half_m, half_m, 0.1]), turn_deg=0.0)
    sun = ShadowSource(np.diag([1.0, -1.0, -1.0]), np.zeros(3), is_sun=True)
    out = np.empty((MAP_SIDE, MAP_SIDE), np.float32)
    made = render_shadow_map(sun, world.box, world.shared, body_poses(world.data), out)
    assert made is not None
    rows, columns = made.size
    assert max(rows, columns) <= MAP_SIDE
    used = np.isfinite(out[:rows, :columns])
    assert not used[[0, -1]].any()
    assert not used[:, [0, -1]].any()
    assert used[2:-3, 2:-3].mean() > 0.9


@pytest.mark.parametrize("light", [SUN, LAMP])
def test_an_object_without_casting_triangles_has_no_map(world: World, light: int) -> None:
    none, out = share_corners(world.soup.of_bodies([])), np.zeros((MAP_SIDE, MAP_SIDE), np.float32)
    poses = body_poses(world.data)
    source = world.source(light)
    assert render_shadow_map(source, world.box, none, poses, out) is None
