"""The photometric camera on models that are not street scenes."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from emulator import EventSensor, SensorConfig
from sim import PhotometricCamera, RendererError, SceneConfigError, open_model
from sim.photometric_camera import EXAMPLE_LIGHT
from sim.scene.assets import ASSETS

SIZE: dict[str, Any] = {"width": 64, "height": 48}
ROOM = """
<mujoco>
  <custom><numeric name="filament.ao.enabled" data="0"/>{text}</custom>
  <asset><material name="m" rgba="{rgba} 1" metallic="0" roughness="1"/></asset>
  <worldbody>
    {light}
    <camera name="down" pos="0 0 3" fovy="40"/>
    <camera name="side" pos="0 -3 1" xyaxes="1 0 0 0 0 1"/>
    <geom type="plane" size="50 50 .1" material="m"/>{more}
  </worldbody>
</mujoco>"""
LINEAR = '<text name="filament.material.base_color_type" data="linear"/>'
BALL = '<body pos="9 9 1"><freejoint/><geom size=".1"/></body>'


def room(
    light: str = EXAMPLE_LIGHT, more: str = BALL, rgba: str = "1 1 1", text: str = LINEAR
) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(ROOM.format(light=light, more=more, rgba=rgba, text=text))


@pytest.fixture(scope="module")
def pendulum() -> mujoco.MjModel:
    return open_model(ASSETS / "pendulum.xml")


@pytest.fixture(scope="module")
def eye(pendulum: mujoco.MjModel) -> Iterator[PhotometricCamera]:
    with PhotometricCamera(pendulum, "eye", width=173, height=130) as camera:
        yield camera


def raised_pendulum(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return data


def test_the_example_of_the_readme(capsys: pytest.CaptureFixture[str]) -> None:
    model = open_model(ASSETS / "pendulum.xml")
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    sensor = EventSensor(SensorConfig(), seed=1)
    with PhotometricCamera(model, "eye", width=346, height=260) as camera:
        for _ in range(10):
            mujoco.mj_step(model, data)
            output = sensor.step(round(data.time * 1e6), camera.luminance(data))
            print(f"{data.time:.3f} s: {len(output.events)} events")
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 10
    assert int(lines[-1].split()[2]) > 5


def test_events_of_a_physics_run_are_where_the_pendulum_swings(
    pendulum: mujoco.MjModel, eye: PhotometricCamera
) -> None:
    sensor = EventSensor(SensorConfig.noise_free(width=173, height=130), seed=0)
    data, counts = raised_pendulum(pendulum), np.zeros((130, 173), np.int64)
    for _ in range(12):
        mujoco.mj_step(pendulum, data, nstep=10)
        moving = eye.visible(data).body == pendulum.body("pendulum").id
        events = sensor.step(round(data.time * 1e6), eye.luminance(data)).events
        np.add.at(counts, (events["y"], events["x"]), 1)
        assert moving.any()
    assert counts.sum() > 500
    assert (
        counts[:, :20].sum() < 0.02 * counts.sum()
    )  # it starts on the left, but not that far left
    assert counts[:20, 100:].sum() == 0


def test_depth_agrees_with_ray_casting(pendulum: mujoco.MjModel, eye: PhotometricCamera) -> None:
    data = raised_pendulum(pendulum)
    depth = eye.depth_m(data)
    mujoco.mj_forward(pendulum, data)
    position, axes = data.cam_xpos[0], data.cam_xmat[0].reshape(3, 3)
    hits = 0
    for row, column in [(65, 86), (100, 40), (120, 140), (10, 10), (34, 47)]:
        x = (column + 0.5 - 86.5) / eye.intrinsics.focal_px
        y = (row + 0.5 - 65) / eye.intrinsics.focal_px
        ray = axes @ np.array([x, -y, -1.0])
        length = np.linalg.norm(ray)
        geom = np.zeros(1, np.int32)
        distance = mujoco.mj_ray(pendulum, data, position, ray / length, None, 1, -1, geom)
        if distance < 0:
            assert np.isinf(depth[row, column])
        else:
            hits += 1
            assert depth[row, column] == pytest.approx(
                distance / length, rel=2e-3
            )  # curved surfaces are faceted
    assert hits >= 3


def test_flow_follows_from_joint_velocities(
    pendulum: mujoco.MjModel, eye: PhotometricCamera
) -> None:
    """Every point of the pendulum moves at ω × r about its hinge; nothing else moves."""
    data = raised_pendulum(pendulum)
    data.qvel[:] = 2.0
    flow, visible = eye.flow_px_s(data), eye.visible(data)
    on_pendulum = visible.body == pendulum.body("pendulum").id
    assert np.abs(flow[~on_pendulum]).max() < 1e-3
    assert on_pendulum.sum() > 200
    mujoco.mj_forward(pendulum, data)
    axes = data.cam_xmat[0].reshape(3, 3) * [1, -1, -1]  # columns right, down, forward
    rows, columns = np.nonzero(on_pendulum)
    focal, depth = eye.intrinsics.focal_px, 1 / visible.nearness[on_pendulum].astype(np.float64)
    x, y = (columns + 0.5 - 86.5) / focal, (rows + 0.5 - 65) / focal
    places = (
        data.cam_xpos[0] + (np.stack([x, y, np.ones(len(x))], axis=1) * depth[:, None]) @ axes.T
    )
    velocity = np.cross([0, 2.0, 0], places - [0, 0, 0.8]) @ axes
    expected = np.stack(
        [velocity[:, 0] - x * velocity[:, 2], velocity[:, 1] - y * velocity[:, 2]], axis=1
    )
    assert flow[on_pendulum] == pytest.approx(expected * (focal / depth)[:, None], abs=1e-3)


def test_the_data_is_not_changed(pendulum: mujoco.MjModel, eye: PhotometricCamera) -> None:
    data = raised_pendulum(pendulum)
    mujoco.mj_step(pendulum, data)
    before = data.xpos.copy(), data.qpos.copy(), data.cam_xpos.copy()
    first = eye.luminance(data)
    eye.flow_px_s(data)
    assert all(
        np.array_equal(a, b)
        for a, b in zip(before, (data.xpos, data.qpos, data.cam_xpos), strict=True)
    )
    assert np.array_equal(first, eye.luminance(data))


@pytest.mark.parametrize(
    ("rgba", "text", "reflectance"),
    [
        (".5 .5 .5", LINEAR, 0.5),
        (".5 .5 .5", "", 0.2140),  # sRGB
        ("0 .5 0", "", 0.2140 * 0.7152),
    ],
)
def test_a_lambertian_floor_reads_lux_times_reflectance_over_pi(
    rgba: str, text: str, reflectance: float
) -> None:
    model = room(rgba=rgba, text=text)
    with PhotometricCamera(model, "down", **SIZE) as camera:
        luminance = camera.luminance(mujoco.MjData(model))
    # Every dielectric also has a faint gloss, which reflects a few per cent.
    assert 1000 * reflectance < luminance.mean() * np.pi < 1000 * (reflectance + 0.015)


def test_a_spots_intensity_is_in_candela_and_the_diffuse_colour_scales_it() -> None:
    """E = I / h² below a spot, and 0.7 times that with MuJoCo's default diffuse colour."""
    spot = '<light type="spot" pos="0 0 5" dir="0 0 -1" cutoff="60" range="50" {} intensity="100"/>'
    illuminance = []
    for diffuse in ('diffuse="1 1 1"', ""):
        model = room(light=spot.format(diffuse))
        with PhotometricCamera(model, "down", **SIZE) as camera:
            illuminance.append(camera.luminance(mujoco.MjData(model))[24, 32] * np.pi)
    assert illuminance == pytest.approx([100 / 25, 0.7 * 100 / 25], rel=0.03)


@pytest.mark.parametrize(
    ("attribute", "lux"), [("", 0), ('group="2"', 0), ('castshadow="false"', 1000)]
)
def test_a_geom_casts_a_shadow_unless_the_model_says_that_it_does_not(
    attribute: str, lux: float
) -> None:
    """A plate between the sun and the floor, beside what the camera sees."""
    sun = EXAMPLE_LIGHT.replace("0 0 -1", "1 0 -1")
    plate = f'<geom type="box" size=".5 .5 .01" pos="-2 0 2" {attribute}/>'
    model = room(light=sun, more=BALL + plate)
    with PhotometricCamera(model, "down", **SIZE) as camera:
        centre = camera.luminance(mujoco.MjData(model))[24, 32]
    assert centre * np.pi == pytest.approx(lux * np.sqrt(0.5), rel=0.03, abs=1e-3)


@pytest.mark.parametrize(
    "light", ["", "<light/>", EXAMPLE_LIGHT.replace("/>", ' active="false"/>')]
)
def test_the_error_for_a_model_without_light_proposes_one(light: str) -> None:
    with pytest.raises(SceneConfigError, match='intensity="1000"/>') as refused:
        PhotometricCamera(room(light=light), "down", **SIZE)
    assert EXAMPLE_LIGHT in str(refused.value)


def test_a_model_in_which_nothing_can_move_is_refused_unless_accepted() -> None:
    model = room(more="")
    with pytest.raises(SceneConfigError, match="nothing in the model can move"):
        PhotometricCamera(model, "down", **SIZE)
    with PhotometricCamera(model, "down", **SIZE, still=True) as camera:
        assert camera.luminance(mujoco.MjData(model)).std() < 10


def test_errors_name_missing_files(tmp_path: Path) -> None:
    path = tmp_path / "scene.xml"
    with pytest.raises(SceneConfigError, match=r"scene\.xml"):
        open_model(path)
    path.write_text(
        '<mujoco><asset><texture name="t" type="2d" file="bark.png"/></asset></mujoco>', "utf-8"
    )
    with pytest.raises(
        SceneConfigError, match=r"scene\.xml: .*bark\.png.*put the missing file there"
    ):
        open_model(path)


def test_data_of_another_model_is_refused(eye: PhotometricCamera) -> None:
    with pytest.raises(SceneConfigError, match=r"has 7 positions\. Allowed is 1, "):
        eye.depth_m(mujoco.MjData(room()))


def test_reading_a_closed_camera_is_refused(pendulum: mujoco.MjModel) -> None:
    with PhotometricCamera(pendulum, "eye", **SIZE) as camera:
        pass
    with pytest.raises(RendererError, match="closed"):
        camera.luminance(raised_pendulum(pendulum))


class LostDevice:
    """A renderer context whose device no longer responds: it never writes a pixel."""

    def __init__(self, error: str | None) -> None:
        self._error = error

    def render(self, *_: Any) -> int:
        return 0

    def wait_for_frame(self, _: int) -> None:
        if self._error:  # a new one each time: its traceback keeps the renderer open
            raise RuntimeError(self._error)


@pytest.mark.parametrize("error", [None, "VK_ERROR_DEVICE_LOST"])
def test_a_device_lost_during_a_run_is_reported(
    pendulum: mujoco.MjModel, error: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = raised_pendulum(pendulum)
    with PhotometricCamera(pendulum, "eye", **SIZE) as camera:
        before = camera.luminance(data)
        with monkeypatch.context() as lost:
            lost.setattr(camera._renderer, "_context", LostDevice(error))
            with pytest.raises(RendererError, match="Vulkan device delivered no frame"):
                camera.luminance(data)
        assert np.array_equal(camera.luminance(data), before)


def test_the_error_for_a_missing_device_says_what_to_install(
    pendulum: mujoco.MjModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sim.render.vulkan.vulkan_devices", list)
    with pytest.raises(RendererError, match="apt-get install"):
        PhotometricCamera(pendulum, "eye", **SIZE)


def test_a_tracking_camera_moves_with_its_body() -> None:
    """It looks down at the floor from 2 m above a ball that rises by 1 m."""
    follower = '<camera name="follower" mode="trackcom" pos="0 0 2" fovy="10"/>'
    model = room(more=BALL.replace("<freejoint/>", f"<freejoint/>{follower}"))
    data = mujoco.MjData(model)
    with PhotometricCamera(model, "follower", **SIZE) as camera:
        before = camera.depth_m(data).max()  # finite: no gap along the floor's diagonal
        data.qpos[2] += 1.0
        data.qvel[2] = 3.0
        after, flow = camera.depth_m(data).max(), camera.flow_px_s(data)
    assert (before, after) == pytest.approx((3.0, 4.0), rel=1e-4)
    # The floor recedes at 3 m/s: a point at slope s moves inwards at f·s·v/Z.
    corner = np.array([0.5 - 32, 0.5 - 24])
    assert flow[0, 0] == pytest.approx(-corner * 3.0 / 4.0, rel=1e-3)
