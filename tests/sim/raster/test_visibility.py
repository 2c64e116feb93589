"""Visibility at pixel centres: computed directly, or overlaid from sub-pixels."""

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rigid_transform import body_poses
from sim.raster.scan_conversion import NO_LABEL
from sim.raster.triangles import TriangleSoup, triangle_soup
from sim.raster.visibility import visibility_map

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
