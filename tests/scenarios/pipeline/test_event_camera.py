"""An event camera beside a simulation that flybench has no part in."""

import warnings
from typing import Any

import mujoco
import numpy as np
import pytest

from emulator import ApsFrame, SensorConfig
from flybench.events import Events
from scenarios.errors import ScenarioError
from scenarios.pipeline.event_camera import BELIEVABLE_PX, EventCamera, MotionWarning
from sim import SceneConfigError, open_model
from sim.photometric_camera import EXAMPLE_LIGHT
from sim.scene.assets import ASSETS

SENSOR = SensorConfig.noise_free(width=87, height=65)


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return open_model(ASSETS / "pendulum.xml")


def drawn_aside(model: mujoco.MjModel, speed_rad_s: float = 0.0) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.qvel[:] = speed_rad_s
    return data


def watched(model: mujoco.MjModel, data: mujoco.MjData, steps: int, **options: Any) -> Any:
    """Events, frames, how far the fastest thing went from drawing to drawing, and the camera."""
    events: list[Events] = []
    frames: list[ApsFrame] = []
    travels: list[float] = []
    travel_px = 0.0
    with EventCamera(model, "eye", sensor=SENSOR, supersample=1, **options) as camera:
        for _ in range(steps):
            mujoco.mj_step(model, data)
            drawn = camera.samples
            travel_px += camera._speed_px_s(data) * model.opt.timestep
            output = camera.step(data)
            events.append(output.events)
            frames += output.aps_frames
            if camera.samples > drawn:
                travels.append(travel_px)
                travel_px = 0.0
    return np.concatenate(events), frames, travels[1:], camera


def test_samples_follow_the_motion(model: mujoco.MjModel) -> None:
    data = drawn_aside(model, speed_rad_s=3.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        events, frames, travels, camera = watched(model, data, 60)
    assert max(travels) <= 0.5
    assert 12 < camera.samples < 60
    assert events.size > 200
    assert np.all(np.diff(events["t"]) >= 0)
    assert len(frames) == 3  # 40 a second
    assert frames[0].image.shape == (65, 87)
    assert camera.luminance.shape == (65, 87)


def test_a_still_scene_is_drawn_every_5_ms(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)  # hangs straight down
    events, _, travels, camera = watched(model, data, 50)
    assert camera.samples == 10
    assert events.size == 0
    assert max(travels) < 0.01


def test_a_period_is_kept_and_warned_of_where_things_move_too_far(model: mujoco.MjModel) -> None:
    with pytest.warns(MotionWarning, match=r"move by \d\.\d px in 10000 µs.* shorter period_us"):
        *_, camera = watched(model, drawn_aside(model, 3.0), 31, period_us=10_000)
    assert camera.samples == 4


def test_a_timestep_that_is_too_long_is_warned_of(model: mujoco.MjModel) -> None:
    quick = drawn_aside(model, 60.0)
    with pytest.warns(MotionWarning, match="shorter timestep of the model"):
        *_, travels, _ = watched(model, quick, 3)
    assert max(travels) > BELIEVABLE_PX


def test_light_and_events_are_those_of_camera_and_sensor(model: mujoco.MjModel) -> None:
    first = watched(model, drawn_aside(model, 3.0), 12, seed=4)[0]
    again = watched(model, drawn_aside(model, 3.0), 12, seed=4)[0]
    assert np.array_equal(first, again)
    assert first.size > 0


def test_time_that_goes_back_is_refused(model: mujoco.MjModel) -> None:
    data = drawn_aside(model)
    with EventCamera(model, "eye", sensor=SENSOR, supersample=1) as camera:
        camera.step(data)
        with pytest.raises(ScenarioError, match=r"is 0 µs, and was 0 µs .* after mj_resetData"):
            camera.step(data)


def test_a_shape_of_unknown_motion_needs_a_period() -> None:
    hills = mujoco.MjModel.from_xml_string(f"""<mujoco><asset>
      <hfield name="h" nrow="2" ncol="2" size="5 5 1 .1"/></asset><worldbody>{EXAMPLE_LIGHT}
      <camera name="eye" pos="0 0 3"/><geom type="hfield" hfield="h"/>
      <body pos="0 0 1"><freejoint/><geom size=".1"/></body></worldbody></mujoco>""")
    data = mujoco.MjData(hills)
    with EventCamera(hills, "eye", sensor=SENSOR, supersample=1) as camera:
        camera.step(data)
        mujoco.mj_step(hills, data)
        with pytest.raises(ScenarioError, match=r"is not known: .* or give a period_us"):
            camera.step(data)
    *_, camera = watched(hills, data, 3, period_us=3000)
    assert camera.samples == 2


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"camera": "ear"}, SceneConfigError, "no camera 'ear'. Allowed is one of 'eye'"),
        ({"period_us": 0}, ScenarioError, "period_us is 0; allowed is more than 0"),
        ({"step_px": float("nan")}, ScenarioError, "step_px is nan"),
    ],
)
def test_what_cannot_be_is_refused(
    model: mujoco.MjModel, options: Any, error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        EventCamera(model, **({"camera": "eye"} | options))
