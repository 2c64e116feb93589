"""Visibility at pixel centres: computed directly, or overlaid from sub-pixels."""

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import NEAR_M, Intrinsics, Pose
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.raster.scan_conversion import NO_LABEL, project_triangles, rasterise
from sim.raster.triangles import TriangleSoup, triangle_soup
from sim.raster.visibility import VisibilityMap, overlay_movers, visibility_map

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]

LENS = Intrinsics(width=60, height=40, focal_px=50.0)
POSE = Pose(np.array([0.0, -4.0, 1.0]))
MODEL = """<mujoco><worldbody>
  <geom type="box" size="1 .1 1" pos="-1 0 .6"/>
  <body pos="-.2 -.5 .9"><joint/><geom type="sphere" size=".5"/></body>
  <body pos=".9 1 1.1"><joint/><geom type="box" size=".4 .3 .2" euler="10 20 30"/></body>
</worldbody></mujoco>"""


@pytest.fixture
def world() -> tuple[TriangleSoup, npt.NDArray[np.float64]]:
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return triangle_soup(model), body_poses(data)


def test_body_and_depth_are_those_along_the_pixel_centres_ray(
    world: tuple[TriangleSoup, npt.NDArray[np.float64]],
) -> None:
    soup, poses = world
    visible = visibility_map(soup, poses, POSE, LENS)
    assert visible.nearness[5, 55] == 0
    assert visible.body[5, 55] == NO_LABEL
    assert visible.body[20, 10] == 0
    assert 1 / visible.nearness[20, 10] == pytest.approx(3.9, rel=1e-6)
    assert visible.body[21, 27] == 1
    # Per metre, the ray goes right by (27.5 - 30) / 50 and down by (21.5 - 20) / 50.
    ray = np.array([-2.5 / 50, 1, -1.5 / 50])
    to_centre = np.array([-0.2, 3.5, -0.1])
    along = ray @ to_centre
    depth = (along - np.sqrt(along**2 - ray @ ray * (to_centre @ to_centre - 0.25))) / (ray @ ray)
    assert 1 / visible.nearness[21, 27] == pytest.approx(depth, abs=0.01)


def test_an_earlier_map_is_kept_and_hides_what_is_behind_it(
    world: tuple[TriangleSoup, npt.NDArray[np.float64]],
) -> None:
    soup, poses = world
    at_once = visibility_map(soup, poses, POSE, LENS)
    for first in ([0], [1], [0, 2]):
        before = visibility_map(soup.of_bodies(first), poses, POSE, LENS)
        kept = before.body.copy()
        both = visibility_map(soup.without_bodies(first), poses, POSE, LENS, before)
        np.testing.assert_array_equal(both.body, at_once.body)
        np.testing.assert_array_equal(both.nearness, at_once.nearness)
        np.testing.assert_array_equal(before.body, kept)


@pytest.mark.parametrize("rectangle", [(0, 0, 60, 40), (13, 5, 47, 38)])
@pytest.mark.parametrize("size", [1, 3, 5])
def test_overlaying_subpixels_gives_the_map_of_all_triangles(
    world: tuple[TriangleSoup, npt.NDArray[np.float64]],
    size: int,
    rectangle: tuple[int, int, int, int],
) -> None:
    soup, poses = world
    static, movers = soup.of_bodies([0]), soup.of_bodies([1, 2])
    label, nearness = rasterise_subpixels(static, movers, poses, rectangle, size)
    shown = visibility_map(static, poses, POSE, LENS)
    overlay_movers(shown, label, nearness, rectangle, size)
    wanted = visibility_map(soup, poses, POSE, LENS)
    x0, y0, x1, y1 = rectangle
    part = np.s_[y0:y1, x0:x1]
    np.testing.assert_array_equal(shown.body[part], wanted.body[part])
    np.testing.assert_allclose(shown.nearness[part], wanted.nearness[part], rtol=1e-5)
    outside = np.ones(shown.body.shape, bool)
    outside[part] = False
    assert (shown.body[outside] <= 0).all()


def rasterise_subpixels(
    static: TriangleSoup,
    movers: TriangleSoup,
    poses: npt.NDArray[np.float64],
    rectangle: tuple[int, int, int, int],
    size: int,
) -> tuple[I32, F32]:
    """Return label and nearness of the movers where nothing static is nearer."""
    x0, y0, x1, y1 = (size * edge for edge in rectangle)
    nearness = np.zeros((y1 - y0, x1 - x0), np.float32)
    label = np.full(nearness.shape, NO_LABEL, np.int32)
    for soup in (static, movers):
        label.fill(NO_LABEL)
        triangles = soup.transformed(compose_transforms(poses, POSE.world_to_camera))
        centre = LENS.width * size / 2, LENS.height * size / 2
        projected, source = project_triangles(triangles, LENS.focal_px * size, *centre, NEAR_M)
        rasterise(projected, soup.body[source], x0, y0, nearness, label, True)
    return label, nearness


def test_with_even_supersampling_the_subpixel_after_the_centre_is_taken() -> None:
    visible = VisibilityMap(np.zeros((2, 2), np.int32), np.ones((2, 2), np.float32))
    label = np.full((8, 8), NO_LABEL, np.int32)
    label[2, 6] = 5
    overlay_movers(visible, label, np.full((8, 8), 2, np.float32), (0, 0, 2, 2), 4)
    np.testing.assert_array_equal(visible.body, [[0, 5], [0, 0]])
    np.testing.assert_array_equal(visible.nearness, [[1, 2], [1, 1]])
