"""Trajectory of the robot arm for a dataset: swings of random size and duration.

flybench dataset examples/robot_arm/dataset.toml
"""

import mujoco
import numpy as np


def swing(model: mujoco.MjModel, seed: int, swing_s: float):
    """Return the function that places the arm at a time, between the keyframe and its mirror image.

    Args:
        model: the model of `arm.xml`.
        seed: seed of the size of the swing.
        swing_s: time from one end to the other [s].
    """
    size = np.random.default_rng(seed).uniform(0.6, 1.2)
    start_rad = model.key_qpos[0]

    def place(data: mujoco.MjData, t_s: float) -> None:
        data.qpos[:] = size * start_rad * np.cos(np.pi * t_s / swing_s)

    return place
