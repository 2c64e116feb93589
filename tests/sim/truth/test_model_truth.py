"""Ground truth of any model, compared with the renderer's segmentation and with closed forms."""

from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from sim import PhotometricCamera, SceneConfigError
from sim.geometry.rectangles import image_rectangle
from sim.raster.aperture import BLUR_REACH_PX
from sim.render.filament import FAR_M

WIDTH, HEIGHT = 96, 72
FOCAL_PX = HEIGHT / 2 / np.tan(np.radians(22.5))
ASSETS = '<mesh name="wedge" vertex="0 0 0  .6 0 0  0 .6 0  0 0 .6  .3 .3 .5"/>'
ASSETS += '<material name="clear" rgba="1 1 1 0"/>'
ASSETS += """<hfield name="hills" nrow="3" ncol="4" size=".6 .4 .3 .2"
  elevation="0 .3 .9 .2  .5 .5 1 .2  .1 .8 .4 .6"/>"""
EYE = '<camera name="eye" pos="0 -2 0" xyaxes="1 0 0 0 0 1" fovy="45"/>'
SUN = '<light type="directional" dir="0 1 -.3" diffuse="1 1 1" intensity="1000"/>'
BALL = '<body name="ball"><joint type="slide" axis="1 0 0"/><geom size=".2" mass="1"/></body>'
PLATE = 'type="box" size=".3 .05 .3" pos="0 -.3 0" euler="0 20 5"'
ENDS = """<site name="left" pos="-.4 0 .1" size=".03"/>{}
  <body name="slider"><joint type="slide" axis="{axis}"/><geom size=".02" pos=".4 0 .1" mass="1"/>
  <site name="right" pos=".4 0 .1" size=".03"/></body>"""
PULLEY = """<site name="over" pos="0 0 .4" size=".001"/>
  <geom name="pulley" type="cylinder" euler="90 0 0" size=".1 .1" pos="0 0 .1"/>"""
TENDON = """<tendon><spatial name="rope" width="{width}" {more}>
  <site site="left"/>{via}<site site="right"/></spatial></tendon>"""
VIA = '<geom geom="pulley" sidesite="over"/>'
CRANK = """<body><joint axis="0 1 0"/><geom size=".02"/><site name="crank" pos=".3 0 0" size=".01"/>
  </body><site name="slot" pos="-.4 0 0" zaxis="1 0 0" size=".01"/>"""
CRANKS = """<visual><scale slidercrank="9"/></visual><actuator>
  <general cranksite="crank" slidersite="slot" cranklength=".5"/></actuator>"""
SKIN_BODIES = "".join(
    f'<body name="{name}" pos="{x} 0 0"><joint type="slide" axis="{axis}"/>'
    '<geom size=".05" mass="1"/></body>'
    for name, x, axis in [("a", -0.3, "1 0 0"), ("b", 0.3, "0 0 1")]
)
SKIN = """<deformable><skin name="skin" inflate=".01" rgba="1 1 1 1"
  vertex="-.3 0 -.2  .3 0 -.2  .3 0 .2  -.3 0 .2" face="0 1 2  0 2 3">
  <bone body="a" bindpos="-.3 0 0" bindquat="1 0 0 0" vertid="0 3" vertweight="1 1"/>
  <bone body="b" bindpos=".3 0 0" bindquat="1 0 0 0" vertid="1 2" vertweight="1 1"/>
</skin></deformable>"""


def model_of(content: str, more: str = "", eye: str = EYE) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(
        f"<mujoco><asset>{ASSETS}</asset><worldbody>{SUN}{eye}{content}</worldbody>{more}</mujoco>"
    )


def flex(dim: int, euler: str, more: str = "") -> str:
    count = {1: "6 1 1", 2: "5 5 1", 3: "3 3 3"}[dim]
    return (
        f'<flexcomp name="flex" type="grid" count="{count}" spacing=".15 .15 .15" mass="1" '
        f'radius=".03" dim="{dim}" euler="{euler}" {more}><edge equality="true"/></flexcomp>'
    )


def expected_bodies(
    camera: PhotometricCamera, model: mujoco.MjModel, data: mujoco.MjData
) -> npt.NDArray[np.int64]:
    """Body of each pixel by the renderer's segmentation, which numbers all elements in a row."""
    camera.luminance(data)
    renderer, pose = camera._renderer, camera._state.load(data)
    assert renderer is not None
    element = renderer.segmentation(pose, image_rectangle(camera.intrinsics))
    numbers = {(item.kind, item.number): k for k, item in enumerate(camera.deforming)}
    deforming = [
        model.nbody + numbers.get((kind, k), -1000)
        for kind, count in [
            ("flex", model.nflex),
            ("skin", model.nskin),
            ("tendon", model.ntendon),
            ("actuator", model.nu),
        ]
        for k in range(count)
    ]
    rigid = [*model.body_weldid[model.geom_bodyid], *model.body_weldid[model.site_bodyid]]
    return np.array([*rigid, *deforming, -1])[element]


CASES = {
    **{f"geom group {k}": (f'<geom {PLATE} group="{k}"/>', "") for k in range(1, 4)},
    **{f"site group {k}": (f'<site {PLATE} group="{k}"/>', "") for k in (2, 5)},
    "transparent": (f'<geom {PLATE} rgba="1 1 1 0"/>', ""),
    "transparent material": (f'<geom {PLATE} material="clear"/>', ""),
    "translucent": (f'<geom {PLATE} rgba="1 1 1 .3"/>', ""),
    "capsule site": ('<site type="capsule" size=".2 .3" euler="10 20 30" pos=".3 0 .2"/>', ""),
    "mesh site": ('<site type="mesh" mesh="wedge" pos=".1 -.5 .2" euler="10 20 30"/>', ""),
    "height field": ('<geom type="hfield" hfield="hills" euler="30 10 20"/>', ""),
    "height field from below": ('<geom type="hfield" hfield="hills" euler="140 0 50"/>', ""),
    "rope": (ENDS.format(PULLEY, axis="1 0 0"), TENDON.format(width=0.05, more="", via=VIA)),
    "hidden rope": (
        ENDS.format(PULLEY, axis="1 0 0"),
        TENDON.format(width=0.05, more='group="3"', via=VIA),
    ),
    "slack rope": (
        ENDS.format("", axis="1 0 0"),
        TENDON.format(width=0.03, more='range="0 1.1" limited="true"', via=""),
    ),
    **{f"flex of {dim} dimensions": (flex(dim, "60 10 20"), "") for dim in (1, 2, 3)},
    "flex from behind": (flex(2, "-100 20 30"), ""),
    "hidden flex": (flex(2, "60 10 20", 'group="4"'), ""),
    "skin": (SKIN_BODIES, SKIN),
    "slider-crank": (CRANK, CRANKS),
    "infinite plane": ('<geom type="plane" size="0 3 1" pos="3 2 -9"/>', ""),
    "plane from below": ('<geom type="plane" size="0 0 1" pos="3 2 1"/>', ""),
    "before the far plane": (f'<geom type="box" size="9 1 9" pos="0 {FAR_M - 2} 0"/>', ""),
    "beyond the far plane": (f'<geom type="box" size="9 1 9" pos="0 {FAR_M} 0"/>', ""),
}
UNSEEN = {"geom group 3", "site group 5", "transparent", "transparent material"}
UNSEEN |= {"hidden rope", "hidden flex", "beyond the far plane"}


@pytest.mark.parametrize("case", CASES)
def test_exactly_what_is_rendered_is_visible(case: str) -> None:
    content, more = CASES[case]
    model = model_of(content + BALL, more)
    data = mujoco.MjData(model)
    with PhotometricCamera(model, "eye", width=WIDTH, height=HEIGHT, supersample=1) as camera:
        body, expected = camera.visible(data).body, expected_bodies(camera, model, data)
        lit = camera.luminance(data) > 0.1  # less than the blur of a pixel at an edge
    assert (body != expected).mean() < 3e-4
    assert not lit[(body == -1) & _far_from_edges(body)].any()
    ball = model.body("ball").id
    shown = set(np.unique(body)) - {-1, ball}
    assert bool(shown) != (case in UNSEEN) or "rope" in case or "skin" in case


@pytest.mark.parametrize(
    "lens",
    [
        'focal=".006 .006"',
        'focal=".004 .006"',
        'focal=".005 .006" principal=".0005 -.0008"',
    ],
)
def test_any_lens_of_a_model_is_rendered_and_measured_alike(lens: str) -> None:
    """A sensor of another shape than the image, and an axis off its middle."""
    eye = EYE.replace('fovy="45"', f'sensorsize=".007 .004" {lens}')
    ball = BALL.replace("<body", '<body pos=".6 0 .2"')
    model = model_of(flex(2, "60 10 20") + ball, eye=eye)
    data = mujoco.MjData(model)
    with PhotometricCamera(model, "eye", width=WIDTH, height=HEIGHT) as camera:
        expected = expected_bodies(camera, model, data)
        assert (camera.visible(data).body != expected).mean() < 3e-4
        # The flow is how far points move in the image.
        data.qvel[:] = 0.3
        flow, seen = camera.flow_px_s(data), camera.visible(data)
        later = mujoco.MjData(model)
        later.qpos[:] = data.qpos
        mujoco.mj_integratePos(model, later.qpos, data.qvel, 0.2)
        moved = camera.visible(later)
    for body in (model.body("ball").id, model.nbody):
        before, after = (np.argwhere(view.body == body).mean(axis=0) for view in (seen, moved))
        mean = flow[seen.body == body].mean(axis=0)[::-1]
        np.testing.assert_allclose((after - before) / 0.2, mean, rtol=0.08, atol=0.5)


def _far_from_edges(body: npt.NDArray[np.int32]) -> npt.NDArray[np.bool_]:
    """Pixels around which, as far as the lens blurs, all pixels show the sky."""
    reach, side = BLUR_REACH_PX, 2 * BLUR_REACH_PX + 1
    sky = np.pad(body == -1, reach, constant_values=True)
    views = [sky[y : y + HEIGHT, x : x + WIDTH] for y in range(side) for x in range(side)]
    return np.asarray(np.all(views, axis=0))


def test_a_transparent_geom_casts_no_shadow() -> None:
    """A plate between sun and ball changes the image if it has a colour, and only then."""
    images = []
    for rgba in ("1 1 1 0", "1 1 1 1"):
        plate = f'<geom type="box" size=".3 .01 .3" pos="0 -3 .9" rgba="{rgba}"/>'
        images.append(luminance_of(model_of(plate + BALL)))
    bare = luminance_of(model_of(BALL))
    np.testing.assert_array_equal(images[0], bare)
    assert images[1].max() < 0.5 * bare.max()


def luminance_of(model: mujoco.MjModel) -> npt.NDArray[np.float32]:
    with PhotometricCamera(model, "eye", width=WIDTH, height=HEIGHT, still=True) as camera:
        return camera.luminance(mujoco.MjData(model))


COLOURED = {
    "site": ('<site type="box" size=".5 .5 .5" pos="0 .5 0" {}/>', ""),
    "flex": (flex(2, "90 0 0", "{}"), ""),
    "tendon": (
        ENDS.format("", axis="1 0 0"),
        TENDON.format(width=0.3, more="{}", via=""),
    ),
    "skin": (SKIN_BODIES, SKIN.replace('rgba="1 1 1 1"', "{}")),
    "actuator": (
        CRANK,
        CRANKS.replace("<scale", '<rgba slidercrank="{}" crankbroken="{}"/><scale'),
    ),
}


@pytest.mark.parametrize("kind", COLOURED)
def test_everything_rendered_has_the_luminance_of_its_colour(kind: str) -> None:
    """A coloured thing is as bright as the same thing in the grey of the same luminance."""
    linear = '<custom><text name="filament.material.base_color_type" data="linear"/></custom>'
    content, more = COLOURED[kind]
    images = []
    for rgb in ("1 0 0", "0 0 1", ".2126 .2126 .2126", ".0722 .0722 .0722"):
        attribute = f"{rgb} 1" if kind == "actuator" else f'rgba="{rgb} 1"'
        filled = (text.replace("{}", attribute) for text in (content, more + linear))
        images.append(luminance_of(model_of(*filled)))
    red, blue, grey, dark = images
    np.testing.assert_allclose(red, grey, rtol=2e-3, atol=1e-3)
    np.testing.assert_allclose(blue, dark, rtol=2e-3, atol=1e-3)
    middle = HEIGHT // 2, WIDTH // 2
    assert red[middle] > 1.5 * blue[middle] > 0


def flow_and_visible(
    model: mujoco.MjModel, data: mujoco.MjData
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.bool_], npt.NDArray[np.float32]]:
    """Flow where the first deforming object is visible, where that is, and its nearness."""
    with PhotometricCamera(model, "eye", width=WIDTH, height=HEIGHT) as camera:
        seen, flow = camera.visible(data), camera.flow_px_s(data)
    where = seen.body == model.nbody
    assert where.sum() > 40
    assert np.abs(flow[seen.body == -1]).max() == 0
    return flow[where], where, seen.nearness[where]


def test_a_moving_flex_has_the_flow_of_its_vertices() -> None:
    model = model_of(flex(2, "90 0 0"))
    data = mujoco.MjData(model)
    data.qvel[:] = np.tile([0.3, 0.1, -0.2], model.nv // 3)
    later = mujoco.MjData(model)
    later.qpos[:] = data.qpos + data.qvel
    for state in (data, later):
        mujoco.mj_forward(model, state)
    velocity = (later.flexvert_xpos - data.flexvert_xpos)[0]
    flow, where, near = flow_and_visible(model, data)
    rows, columns = np.nonzero(where)
    x, y = (columns + 0.5 - WIDTH / 2) / FOCAL_PX, (rows + 0.5 - HEIGHT / 2) / FOCAL_PX
    expected = np.stack([velocity[0] - x * velocity[1], -velocity[2] - y * velocity[1]], axis=1)
    np.testing.assert_allclose(flow, expected * FOCAL_PX * near[:, None], atol=0.02)
    assert np.abs(flow).min() > 1


def test_the_flow_of_a_rope_grows_towards_its_moving_end() -> None:
    """The right end rises at 1 m/s, the left one is fixed: the speed is linear between them."""
    model = model_of(
        ENDS.format("", axis="0 0 1"), TENDON.format(width=0.02, more='group="2"', via="")
    )
    data = mujoco.MjData(model)
    data.qvel[:] = 1.0
    flow, where, near = flow_and_visible(model, data)
    columns = np.nonzero(where)[1]
    x_m = (columns + 0.5 - WIDTH / 2) / FOCAL_PX / near
    inside = np.abs(x_m) < 0.35
    expected = -(x_m[inside] + 0.4) / 0.8 * FOCAL_PX * near[inside]
    np.testing.assert_allclose(flow[inside, 1], expected, rtol=0.02, atol=0.2)


def test_a_skin_moves_with_its_bones() -> None:
    """The left half follows body a along x, the right one body b along z, linearly between."""
    model = model_of(SKIN_BODIES, SKIN)
    data = mujoco.MjData(model)
    data.qvel[:] = [0.5, 0.25]
    flow, where, near = flow_and_visible(model, data)
    columns = np.nonzero(where)[1]
    share = (columns + 0.5 - WIDTH / 2) / FOCAL_PX / near / 0.6 + 0.5
    np.testing.assert_allclose(flow[:, 0], 0.5 * (1 - share) * FOCAL_PX * near, atol=0.05)
    np.testing.assert_allclose(flow[:, 1], -0.25 * share * FOCAL_PX * near, atol=0.05)


def test_a_camera_that_moves_sees_what_deforms_move() -> None:
    eye = f'<body><joint type="slide" axis="1 0 0"/><geom size=".01" mass="1"/>{EYE}</body>'
    model = model_of(flex(2, "90 0 0", 'name="f"').replace('name="flex" ', ""), eye=eye)
    data = mujoco.MjData(model)
    data.qvel[0] = 0.5
    flow, _, near = flow_and_visible(model, data)
    np.testing.assert_allclose(flow[:, 0], -0.5 * FOCAL_PX * near, atol=0.02)
    np.testing.assert_allclose(flow[:, 1], 0.0, atol=0.02)


def test_a_rope_that_begins_to_touch_a_geom_keeps_its_flow() -> None:
    """It touches within the millisecond before or after, so its number of parts changes."""
    model = model_of(ENDS.format(PULLEY, axis="0 0 1"), TENDON.format(width=0.02, more="", via=VIA))
    data = mujoco.MjData(model)
    data.qvel[:] = 1.0
    counts, flows = [], []
    for height in np.arange(0.05, 0.25, 0.0005):
        data.qpos[:] = height
        mujoco.mj_forward(model, data)
        counts.append(int(data.ten_wrapnum[0]))
    change = 0.05 + 0.0005 * (int(np.flatnonzero(np.diff(counts))[0]) + 0.5)
    for height in (change - 0.0004, change + 0.0004):
        data.qpos[:] = height
        flows.append(flow_and_visible(model, data)[0])
    assert all(np.isfinite(flow).all() and np.abs(flow).max() > 10 for flow in flows)


def test_tendons_with_too_many_parts_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a warning to a file there
    monkeypatch.setattr("sim.raster.deforming.MAX_PARTS", 5)
    model = model_of(*CASES["rope"])
    with (
        PhotometricCamera(model, "eye", width=8, height=8) as camera,
        pytest.raises(SceneConfigError, match=r"have 5 parts or more.*Hide some"),
    ):
        camera.visible(mujoco.MjData(model))
