"""Visible fraction of a box, compared with areas computed by hand."""

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.raster.triangles import TriangleSoup, triangle_soup
from sim.raster.visibility import visibility_map
from sim.raster.visible_fraction import VisibleFraction

LENS = Intrinsics(width=100, height=80, focal_px=100.0)
EYE = Pose(np.zeros(3))  # looks along y


def box(x_m: float, half_m: float = 1.0) -> tuple[TriangleSoup, npt.NDArray[np.float64]]:
    xml = f"""<mujoco><worldbody><body pos="{x_m} 5 0"><freejoint/>
      <geom type="box" size="{half_m} 1 {half_m}"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return triangle_soup(model), body_poses(data)


def visible_fraction(x_m: float, half_m: float = 1.0, hidden: int = 0) -> float:
    """Return the visible fraction of a box whose face is 4 m away, at 25 px per metre.

    The first `hidden` columns of the image show something else.
    """
    soup, poses = box(x_m, half_m)
    labels = visibility_map(soup, poses, EYE, LENS).body.astype(np.int8)
    labels[:, :hidden] = -1
    views = compose_transforms(poses, EYE.world_to_camera)
    return VisibleFraction(soup).measure(views, LENS, labels, 1)


def test_a_box_in_the_centre_is_entirely_visible() -> None:
    assert visible_fraction(0.0) == 1.0


@pytest.mark.parametrize("hidden", [40, 50, 70])
def test_occlusion_reduces_the_fraction(hidden: int) -> None:
    assert visible_fraction(0.0, hidden=hidden) == pytest.approx((75 - hidden) / 50, abs=0.02)


@pytest.mark.parametrize("x_m", [-2.0, 2.0])
def test_the_border_of_the_image_reduces_the_fraction(x_m: float) -> None:
    """The face ends 75 px off the centre, of which the image shows 50. One side is visible, too."""
    inner = 100 * (2.0 - 1.0) / 6  # column of the side's far edge, from the centre
    visible, whole = 50 - inner, 75 - inner
    assert visible_fraction(x_m) == pytest.approx(visible / whole, abs=0.06)


def test_the_fraction_of_a_box_outside_the_image_is_zero() -> None:
    assert visible_fraction(6.0) == 0.0


def test_a_box_larger_than_the_image_is_partly_visible() -> None:
    assert visible_fraction(0.0, half_m=4.0) == pytest.approx(100 * 80 / 200**2, rel=0.05)
