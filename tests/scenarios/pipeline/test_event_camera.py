"""An event camera on a MuJoCo model that is not one of flybench's scenes."""

import warnings
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest

from emulator import ApsFrame, SensorConfig
from flybench.events import Events
from scenarios.errors import ScenarioError
from scenarios.pipeline.event_camera import MAX_TRAVEL_PX, EventCamera, MotionWarning
from sim import SceneConfigError, open_model
from sim.scene.assets import ASSETS

SENSOR = replace(
    SensorConfig.noise_free(width=87, height=65), theta_on=0.18, theta_off=0.22, refractory_us=3
)


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return open_model(ASSETS / "pendulum.xml")


def deflected(model: mujoco.MjModel, speed_rad_s: float = 0.0) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.qvel[:] = speed_rad_s
    return data


def record(model: mujoco.MjModel, data: mujoco.MjData, steps: int, **options: Any) -> Any:
    """Events, frames, greatest motion between renderings [px], and the camera."""
    events: list[Events] = []
    frames: list[ApsFrame] = []
    travels: list[float] = []
    travel_px = 0.0
    with EventCamera(model, "eye", sensor=SENSOR, supersample=1, **options) as camera:
        for _ in range(steps):
            mujoco.mj_step(model, data)
            samples_before = camera.samples
            travel_px += camera._speed_px_s(data) * model.opt.timestep
            output = camera.step(data)
            events.append(output.events)
            frames += output.aps_frames
            if camera.samples > samples_before:
                travels.append(travel_px)
                travel_px = 0.0
    return np.concatenate(events), frames, travels[1:], camera


def test_samples_follow_the_motion(model: mujoco.MjModel) -> None:
    data = deflected(model, speed_rad_s=3.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        events, frames, travels, camera = record(model, data, 60)
    assert max(travels) <= 0.5
    assert 12 < camera.samples < 60
    assert events.size > 200
    assert np.all(np.diff(events["t"]) >= 0)
    assert len(frames) == 3  # 40 a second
    assert frames[0].image.shape == (65, 87)
    assert camera.luminance.shape == (65, 87)


def test_a_scene_at_rest_is_rendered_every_5_ms(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)  # hangs straight down
    events, _, travels, camera = record(model, data, 50)
    assert camera.samples == 10
    assert events.size == 0
    assert max(travels) < 0.01


def test_too_much_motion_in_a_fixed_period_raises_a_warning(model: mujoco.MjModel) -> None:
    with pytest.warns(MotionWarning, match=r"moves by \d\.\d px in 10000 µs.* shorter period_us"):
        *_, camera = record(model, deflected(model, 3.0), 31, period_us=10_000)
    assert camera.samples == 4


def test_a_timestep_that_is_too_long_raises_a_warning(model: mujoco.MjModel) -> None:
    fast = deflected(model, 60.0)
    with pytest.warns(MotionWarning, match="shorter timestep of the model"):
        *_, travels, _ = record(model, fast, 3)
    assert max(travels) > MAX_TRAVEL_PX


def test_the_same_seed_gives_the_same_events(model: mujoco.MjModel) -> None:
    first = record(model, deflected(model, 3.0), 12, seed=4)[0]
    again = record(model, deflected(model, 3.0), 12, seed=4)[0]
    assert np.array_equal(first, again)
    assert first.size > 0


def test_time_that_does_not_advance_is_refused(model: mujoco.MjModel) -> None:
    data = deflected(model)
    with EventCamera(model, "eye", sensor=SENSOR, supersample=1) as camera:
        camera.step(data)
        with pytest.raises(ScenarioError, match=r"is 0 µs, and was 0 µs .* after mj_resetData"):
            camera.step(data)


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"camera": "ear"}, SceneConfigError, "no camera 'ear'. Allowed is one of 'eye'"),
        ({"period_us": 0}, ScenarioError, "period_us is 0. Allowed are numbers above 0"),
        ({"step_px": float("nan")}, ScenarioError, "step_px is nan"),
    ],
)
def test_invalid_arguments_are_refused(
    model: mujoco.MjModel, options: Any, error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        EventCamera(model, **({"camera": "eye"} | options))


TOYS = {
    # As in gymnasium: an infinite checkered floor, a camera that tracks, collision shapes shown.
    "gymnasium": """<asset>
      <texture type="skybox" builtin="gradient" rgb1="1 1 1" rgb2="0 0 0" width="64" height="384"/>
      <texture name="checks" type="2d" builtin="checker" rgb1="0 0 0" rgb2=".8 .8 .8"
        width="100" height="100"/>
      <material name="floor" texture="checks" texrepeat="60 60" reflectance=".5" specular="1"/>
    </asset>
    <worldbody><light cutoff="100" diffuse="1 1 1" dir="0 0 -1.3" directional="true" pos="0 0 1.3"/>
      <geom type="plane" size="40 40 40" material="floor"/>
      <body name="mover" pos="0 0 .6"><camera name="eye" mode="track" pos="0 -3 .3"
        xyaxes="1 0 0 0 0 1"/><joint axis="0 1 0"/><geom fromto="0 0 0 .5 0 .3" size=".08"
        type="capsule" rgba=".8 .6 .4 1"/></body></worldbody>""",
    # As in dm_control: a reflecting grid, sites, a spatial tendon, a cut-off spot light.
    "dm_control": """<asset><texture name="grid" type="2d" builtin="checker" rgb1=".1 .2 .3"
      rgb2=".2 .3 .4" width="300" height="300" mark="edge" markrgb=".2 .3 .4"/>
      <material name="grid" texture="grid" texrepeat="1 1" texuniform="true" reflectance=".2"/>
      <material name="self" rgba=".3 .2 .1 1"/></asset>
    <worldbody><light diffuse=".9 .9 .9" dir="0 0 -1" pos="0 0 3"/>
      <geom type="plane" size="5 5 .2" material="grid"/>
      <camera name="eye" pos="0 -3 1" xyaxes="1 0 0 0 0 1"/><site name="hook" pos="0 0 1.5"/>
      <body name="mover" pos="0 0 .9"><joint axis="0 1 0"/><geom type="box" size=".5 .1 .08"
        material="self"/><site name="eyelet" pos=".25 0 .05" size=".03" rgba="1 0 0 1"/></body>
    </worldbody><tendon><spatial width=".02"><site site="hook"/><site site="eyelet"/></spatial>
    </tendon>""",
    # As in robosuite: collision shapes of group 0 that are transparent, visual ones of group 1.
    "robosuite": """<asset><material name="wood" rgba=".6 .4 .2 1" specular=".4"/></asset>
    <worldbody><light pos="1 1 1.5" dir="-.2 -.2 -1" specular=".3 .3 .3" directional="true"
      castshadow="false"/><geom type="plane" size="3 3 .1" material="wood" group="1"/>
      <camera name="eye" pos="0 -2 .8" xyaxes="1 0 0 0 0 1"/>
      <body name="mover" pos="0 0 .8"><joint axis="0 1 0"/>
        <geom type="box" size=".4 .3 .3" rgba="0 .5 0 0" group="0"/>
        <geom type="box" size=".3 .05 .1" rgba=".9 .9 .9 1" group="1" contype="0"/>
        <site name="centre" size=".3" rgba="1 0 0 .5" group="3"/></body></worldbody>""",
}


@pytest.mark.parametrize("library", TOYS)
@pytest.mark.parametrize("light", ["daylight", "indoor"])
def test_models_of_other_libraries_need_a_light_only(library: str, light: str) -> None:
    """No light of these has an intensity. Events lie where the body moves, and near it."""
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{TOYS[library]}</mujoco>")
    data = mujoco.MjData(model)
    data.qvel[:] = 15.0
    with EventCamera(model, "eye", sensor=SENSOR, supersample=1, light=light) as camera:
        near = np.zeros((65, 87), bool)
        events = []
        for _ in range(8):
            mujoco.mj_step(model, data)
            events.append(camera.step(data).events)
            near |= camera._camera.visible(data).body == model.body("mover").id
    all_events = np.concatenate(events)
    rows, columns = np.nonzero(near)
    inside = (np.abs(all_events["x"] - columns.mean()) < np.ptp(columns) / 2 + 4) & (
        np.abs(all_events["y"] - rows.mean()) < np.ptp(rows) / 2 + 4
    )
    assert 0.01 < near.mean() < 0.3
    assert all_events.size > 40
    assert inside.mean() > 0.6  # others belong to the shadow on the floor


def test_a_camera_with_a_sensor_of_another_shape_is_accepted(model: mujoco.MjModel) -> None:
    lens = 'sensorsize=".016 .009" focal=".01 .012" principal=".001 0"'
    toy = TOYS["dm_control"].replace('name="eye"', f'name="eye" {lens}')
    wide = mujoco.MjModel.from_xml_string(f"<mujoco>{toy}</mujoco>")
    data = mujoco.MjData(wide)
    data.qvel[:] = 15.0
    with EventCamera(wide, "eye", sensor=SENSOR, supersample=1, light="overcast") as camera:
        focal_px = camera.intrinsics.focal_px, camera.intrinsics.focal_px * camera.intrinsics.aspect
        events = []
        for _ in range(5):
            mujoco.mj_step(wide, data)
            events.append(camera.step(data).events)
    assert focal_px == pytest.approx((87 * 10 / 16, 65 * 12 / 9))
    assert camera.intrinsics.axis_px == pytest.approx((-87 / 16, 0))
    assert sum(map(len, events)) > 20
