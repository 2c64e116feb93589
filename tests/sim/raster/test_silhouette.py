"""How much of a box is in the image, against areas by hand."""

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.raster.silhouette import Silhouette
from sim.raster.triangles import Soup, triangle_soup
from sim.raster.visibility import look

LENS = Intrinsics(width=100, height=80, focal_px=100.0)
EYE = Pose(np.zeros(3))  # looks along y


def box(x_m: float, half_m: float = 1.0) -> tuple[Soup, npt.NDArray[np.float64]]:
    xml = f"""<mujoco><worldbody><body pos="{x_m} 5 0"><freejoint/>
      <geom type="box" size="{half_m} 1 {half_m}"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return triangle_soup(model), body_poses(data)


def visibility(x_m: float, half_m: float = 1.0, hidden: int = 0) -> float:
    """Of a box whose face is 4 m away, 25 px to the metre, so many columns of the image hidden."""
    soup, poses = box(x_m, half_m)
    labels = look(soup, poses, EYE, LENS).body.astype(np.int8)
    labels[:, :hidden] = -1
    views = compose_transforms(poses, EYE.into)
    return Silhouette(soup).visibility(views, LENS, labels, 1)


def test_a_box_in_the_middle_is_seen_whole() -> None:
    assert visibility(0.0) == 1.0


@pytest.mark.parametrize("hidden", [40, 50, 70])
def test_what_stands_before_it_counts(hidden: int) -> None:
    assert visibility(0.0, hidden=hidden) == pytest.approx((75 - hidden) / 50, abs=0.02)


@pytest.mark.parametrize("x_m", [-2.0, 2.0])
def test_what_the_border_cuts_off_counts(x_m: float) -> None:
    """The face ends 75 px off the middle, of which the image shows 50; the side is seen, too."""
    inner = 100 * (2.0 - 1.0) / 6  # where the inner side's far edge is
    seen, alone = 50 - inner, 75 - inner
    assert visibility(x_m) == pytest.approx(seen / alone, abs=0.06)


def test_a_box_out_of_the_image_is_not_seen() -> None:
    assert visibility(6.0) == 0.0


def test_a_box_that_fills_more_than_the_image_is_seen_in_part() -> None:
    assert visibility(0.0, half_m=4.0) == pytest.approx(100 * 80 / 200**2, rel=0.05)
