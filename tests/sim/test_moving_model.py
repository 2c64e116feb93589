"""The truth of a model that moves along a trajectory, against geometry by hand."""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
import pytest

from sim import SceneConfigError
from sim.moving_model import MovingModel, Place

WIDTH, HEIGHT = 40, 30
FOCAL_PX = 15 / np.tan(np.radians(45) / 2)
CAMERA = '<camera name="eye" pos="0 0 4" fovy="45"/>'
WALL = '<geom type="plane" size="9 9 .1"/>'
BOX = """<body name="{name}" pos="0 0 1"><joint type="slide" axis="1 0 0"/>
  <geom type="box" size=".4 .3 .2"/>{inside}</body>"""
TENDON = """<tendon><spatial name="cord" width=".1"><site site="a"/><site site="b"/></spatial>
  </tendon>"""
SITES = '<site name="a" pos="0 0 .5"/>', '<site name="b" pos="1 0 1"/>'


def model_of(world: str, rest: str = "") -> Any:
    text = f"<mujoco><worldbody>{world}</worldbody>{rest}</mujoco>"
    return mujoco.MjModel.from_xml_string(text)


def slide(data: Any, t_s: float) -> None:
    data.qpos[0] = 0.5 * t_s


def moving_of(model: Any, place: Place = slide, objects: Sequence[str] = ()) -> MovingModel:
    return MovingModel(model, "eye", place, width=WIDTH, height=HEIGHT, objects=objects)


def test_flow_displacement_and_masks_of_a_sliding_box() -> None:
    world = CAMERA + WALL + BOX.format(name="box", inside="")
    moving = moving_of(model_of(world))
    (item,) = moving.objects
    assert item.name == item.kind == "box"
    seen = moving.visible(0.2)
    on_box = moving.object_of_body[seen.body] == 0
    depth = np.where(on_box, 4 - 1.2, 4.0)
    assert 1 / seen.nearness == pytest.approx(depth, rel=1e-6)
    speed = np.where(on_box, FOCAL_PX * 0.5 / 2.8, 0)
    assert moving.flow_px_s(0.2)[..., 0] == pytest.approx(speed, abs=1e-4)
    assert moving.displacement_px(0.2, 0.6)[..., 0] == pytest.approx(speed * 0.4, abs=1e-4)
    assert moving.fastest_px_s(0.2) == pytest.approx(speed.max(), rel=1e-5)
    columns = np.flatnonzero(on_box.any(axis=0))
    left, right = (20 + FOCAL_PX * (0.1 + side * 0.4) / 2.8 for side in (-1, 1))
    assert abs(columns[0] - left) < 1
    assert abs(columns[-1] + 1 - right) < 1


def test_a_moving_camera_moves_the_background() -> None:
    drone = '<joint type="slide" axis="1 0 0"/><geom size=".1" pos="0 0 9"/>' + CAMERA
    world = f'{WALL}<body name="drone">{drone}</body>'
    moving = moving_of(model_of(world))
    assert moving.pose_at(0.4).position_m == pytest.approx([0.2, 0, 4])
    assert moving.flow_px_s(0.1)[..., 0] == pytest.approx(-FOCAL_PX * 0.5 / 4, abs=1e-4)


def test_a_mocap_body_has_its_velocity() -> None:
    world = CAMERA + WALL + '<body name="hand" mocap="true"><geom size=".5"/></body>'

    def place(data: Any, t_s: float) -> None:
        data.mocap_pos[0] = (t_s, 0, 1)

    moving = moving_of(model_of(world), place)
    assert moving.flow_px_s(0.0)[15, 20, 0] == pytest.approx(FOCAL_PX / 2.5, rel=0.01)


def test_objects_are_whole_trees_or_the_named_bodies() -> None:
    inside = '<body name="lid" pos="0 0 .3"><joint/><geom size=".1"/></body>'
    world = CAMERA + BOX.format(name="box", inside=inside) + BOX.format(name="other", inside="")
    model = model_of(world)
    whole = moving_of(model)
    assert [item.name for item in whole.objects] == ["box", "other"]
    assert whole.object_of_body.tolist() == [-1, 0, 0, 1]
    named = moving_of(model, objects=["lid", "box"])
    assert [item.name for item in named.objects] == ["box", "lid"]
    assert named.object_of_body.tolist() == [-1, 0, 1, -1]


def test_what_deforms_has_a_velocity_and_no_displacement() -> None:
    world = CAMERA + WALL + BOX.format(name="box", inside=SITES[0]) + SITES[1]
    moving = moving_of(model_of(world, TENDON))
    seen, flow = moving.visible(0.0), moving.flow_px_s(0.0)
    on_cord = seen.body >= 2
    assert on_cord.any()
    assert (moving.object_of_body[seen.body[on_cord]] == -1).all()
    assert 0 < flow[on_cord, 0].max() < FOCAL_PX * 0.5 / 2
    with pytest.raises(SceneConfigError, match=r"has the tendon 'cord', which deforms\. Allowed"):
        moving.displacement_px(0.0, 0.1)


@pytest.mark.parametrize(
    ("world", "rest", "objects", "message"),
    [
        (CAMERA + WALL, "", (), r"nothing in the model can move: it has 0 joints and 0 mocap"),
        (
            CAMERA + BOX.format(name="box", inside=""),
            "",
            ("bix",),
            r"no body 'bix' .* one of box\.",
        ),
        (
            CAMERA + '<body mocap="true"><geom size=".1"/></body>' + "".join(SITES),
            TENDON,
            (),
            r"has 1 mocap bodies, which have no velocity, and 1 parts that deform",
        ),
        (
            CAMERA + "".join(BOX.format(name=f"b{k}", inside="") for k in range(128)),
            "",
            (),
            r"has 128 moving objects\. Allowed are 127",
        ),
    ],
)
def test_models_without_truth_are_refused(
    world: str, rest: str, objects: tuple[str, ...], message: str
) -> None:
    with pytest.raises(SceneConfigError, match=message):
        moving_of(model_of(world, rest), objects=objects)


def test_positions_that_are_not_finite_are_refused() -> None:
    world = CAMERA + BOX.format(name="box", inside="")

    def place(data: Any, t_s: float) -> None:
        data.qpos[0] = np.nan

    moving = moving_of(model_of(world), place)
    with pytest.raises(SceneConfigError, match=r"positions that are not finite at 0\.5 s"):
        moving.visible(0.5)
