"""A model's triangles, compared with the renderer's segmentation and with closed forms."""

from collections import Counter

import mujoco
import numpy as np
import pytest

from sim import CrossingConfig
from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.keyframes.background import rasterise_image
from sim.raster.triangles import triangle_soup, unit_normals
from sim.render.filament import FilamentRenderer
from sim.render.luminance_model import luminance_model
from sim.scene.scene import build_scene

SHAPES = """<mujoco>
  <visual><quality numslices="{slices}" numstacks="{stacks}"/></visual>
  <asset><mesh name="wedge" vertex="0 0 0  .6 0 0  0 .6 0  0 0 .6  .3 .3 .5"/></asset>
  <worldbody>
    <light type="directional" dir=".3 1 -1" intensity="1000"/>
    <geom type="plane" size="3 3 .1"/>
    <geom type="box" size=".3 .2 .25" pos="-1.2 0 .5" euler="20 30 40"/>
    <geom type="sphere" size=".3" pos="-.4 0 .4"/>
    <body pos=".4 0 .5" euler="50 20 10"><joint/>
      <geom type="capsule" size=".15 .3"/>
      <body pos=".8 0 .1" euler="0 60 0"><joint/><geom type="cylinder" size=".25 .2"/></body>
    </body>
    <geom type="ellipsoid" size=".3 .2 .15" pos="-1 0 1.2" euler="0 30 70"/>
    <geom type="mesh" mesh="wedge" pos=".2 0 1.1" euler="20 0 40"/>
  </worldbody>
</mujoco>"""
POSE = Pose(np.array([0.0, -3.0, 1.0]))


def differing(model: mujoco.MjModel, data: mujoco.MjData, pose: Pose, lens: Intrinsics) -> float:
    """Return the share of pixels that show another geom than the renderer's segmentation."""
    with FilamentRenderer(luminance_model(model), lens) as renderer:
        renderer.update(data)
        reference = renderer.segmentation(pose, (0, 0, lens.width, lens.height))
    soup = triangle_soup(model)
    triangles = soup.transformed(compose_transforms(body_poses(data), pose.world_to_camera))
    _, triangle = rasterise_image(triangles, lens, 1)
    geom = np.append(soup.geom, -1)[triangle]
    assert len(np.unique(reference)) > 7
    return float((geom != reference).mean())


@pytest.mark.parametrize(("slices", "stacks"), [(8, 3), (6, 10), (28, 16)])
def test_shapes_have_exactly_the_renderers_facets(slices: int, stacks: int) -> None:
    model = mujoco.MjModel.from_xml_string(SHAPES.format(slices=slices, stacks=stacks))
    data = mujoco.MjData(model)
    data.qpos[:] = [0.2, -0.3]
    mujoco.mj_forward(model, data)
    assert differing(model, data, POSE, Intrinsics(120, 80, 100.0).scaled(3)) < 0.0005


def test_the_street_has_the_renderers_silhouettes() -> None:
    scene = build_scene(CrossingConfig())
    data = mujoco.MjData(scene.model)
    scene.place(data, 0.1)
    lens = Intrinsics(116, 87, 324 / 3).scaled(3)
    assert differing(scene.model, data, scene.pose, lens) < 0.0005


def test_invisible_geoms_have_no_triangles() -> None:
    model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody>
      <geom type="box" size="1 1 1" rgba="1 1 1 0"/><geom type="box" size="1 1 1"/>
    </worldbody></mujoco>""")
    assert set(triangle_soup(model).geom) == {1}


def test_bodies_fixed_to_the_world_belong_to_body_0() -> None:
    model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody>
      <body pos="1 0 0"><body pos="0 2 0"><geom type="box" size=".1 .1 .1"/></body></body>
      <body pos="5 0 0"><joint/><body pos="0 1 0"><geom type="box" size=".1 .1 .1"/></body></body>
    </worldbody></mujoco>""")
    soup = triangle_soup(model)
    np.testing.assert_array_equal(np.unique(soup.body), [0, 3])
    centres = [soup.triangles_m[soup.geom == k].mean(axis=(0, 1)) for k in (0, 1)]
    np.testing.assert_allclose(centres, [[1, 2, 0], [0, 1, 0]], atol=1e-12)
    assert set(soup.of_bodies([3]).geom) == {1}
    assert set(soup.without_bodies([3]).geom) == {0}


@pytest.mark.parametrize("kind", ["box", "sphere", "capsule", "ellipsoid", "cylinder"])
def test_shapes_are_closed_and_face_outwards(kind: str) -> None:
    """Each edge is traversed equally often in both directions."""
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><geom type="{kind}" size=".5 .4 .3"/></worldbody></mujoco>'
    )
    triangles = triangle_soup(model).triangles_m
    outwards = np.einsum("ij,ij->i", unit_normals(triangles), triangles.mean(axis=1))
    assert (outwards >= 0).all()
    assert (outwards > 0.1).mean() > 0.9
    ends = np.round(triangles, 9)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 6)
    there = Counter(tuple(edge) for edge in ends + 0.0)
    back = Counter((*edge[3:], *edge[:3]) for edge in there.elements())
    assert there == back


def test_a_triangle_without_area_has_no_normal() -> None:
    np.testing.assert_array_equal(unit_normals(np.zeros((1, 3, 3))), [[0, 0, 0]])
