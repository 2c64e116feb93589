"""Motion of a model through its keyframes."""

import mujoco
import numpy as np
import pytest

from sim import SceneConfigError
from sim.motion.model_keyframes import KeyframeMotion

BODIES = """
<mujoco><worldbody>
  <body name="slider"><joint type="slide" axis="1 0 0"/><geom size=".1"/></body>
  <body name="turner"><joint type="ball"/><geom size=".1"/></body>
  <body name="guided" mocap="true"><geom size=".1"/></body>
</worldbody><keyframe>{keys}</keyframe></mujoco>
"""
HALF = 0.5**0.5
KEYS = f"""
<key time="1" qpos="0 1 0 0 0" mpos="0 0 0" mquat="1 0 0 0"/>
<key time="2" qpos="4 {HALF} 0 0 {HALF}" mpos="1 2 3" mquat="{HALF} {HALF} 0 0"/>
<key time="4" qpos="0 {HALF} 0 0 {HALF}" mpos="1 2 3" mquat="{HALF} {HALF} 0 0"/>
"""


def placed(t_s: float) -> mujoco.MjData:
    model = mujoco.MjModel.from_xml_string(BODIES.format(keys=KEYS))
    data = mujoco.MjData(model)
    KeyframeMotion(model).place(data, t_s)
    return data


@pytest.mark.parametrize(
    ("t_s", "position", "angle_deg"),
    [(0.0, 0.0, 0.0), (0.25, 1.0, 22.5), (1.0, 4.0, 90.0), (2.0, 2.0, 90.0), (-0.5, -2.0, -45.0)],
)
def test_joints_and_mocap_bodies_move_at_constant_velocity(
    t_s: float, position: float, angle_deg: float
) -> None:
    data, half = placed(t_s), np.radians(angle_deg) / 2
    assert data.qpos[0] == pytest.approx(position)
    assert data.qpos[1:] == pytest.approx([np.cos(half), 0, 0, np.sin(half)])
    assert data.mocap_pos[0] == pytest.approx(np.array([1, 2, 3]) * angle_deg / 90)
    assert data.mocap_quat[0] == pytest.approx([np.cos(half), np.sin(half), 0, 0])


def test_times_count_from_the_first_keyframe() -> None:
    model = mujoco.MjModel.from_xml_string(BODIES.format(keys=KEYS))
    assert KeyframeMotion(model).duration_s == 3


@pytest.mark.parametrize("keys", ["", '<key time="1"/>', '<key time="1"/><key time="1"/>'])
def test_times_that_do_not_increase_are_refused(keys: str) -> None:
    model = mujoco.MjModel.from_xml_string(BODIES.format(keys=keys))
    with pytest.raises(SceneConfigError, match=r"have the times .* Allowed are two or more"):
        KeyframeMotion(model)
