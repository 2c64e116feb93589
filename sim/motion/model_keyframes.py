"""Motion of any MuJoCo model through the keyframes of its file."""

from __future__ import annotations

import mujoco
import numpy as np

from sim.errors import SceneConfigError


class KeyframeMotion:
    """Motion of a model through its keyframes, at constant velocity between two of them.

    Joints and mocap bodies turn the shorter way between two keyframes. Before the first and after
    the last keyframe the motion goes on with the velocity that it has there.

    Attributes:
        duration_s: time from the first to the last keyframe [s].
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        """Read the times of the keyframes.

        Args:
            model: the model, which is not changed.

        Raises:
            SceneConfigError: there are fewer than two keyframes, or their times do not increase.
        """
        times_s = np.array(model.key_time)
        if len(times_s) < 2 or not (np.diff(times_s) > 0).all():
            raise SceneConfigError(
                f"the keyframes of the model have the times {times_s.tolist()} s. Allowed are two "
                'or more, in the order of their times. Write <key time="0.5" qpos="..."/> for each.'
            )
        self._model = model
        self._times_s = times_s - times_s[0]
        self.duration_s = float(self._times_s[-1])

    def place(self, data: mujoco.MjData, t_s: float) -> None:
        """Set the positions of all joints and mocap bodies for a time after the first keyframe."""
        model, times_s = self._model, self._times_s
        k = int(np.clip(np.searchsorted(times_s, t_s, side="right") - 1, 0, len(times_s) - 2))
        share = (t_s - times_s[k]) / (times_s[k + 1] - times_s[k])
        rates = np.zeros(model.nv)
        mujoco.mj_differentiatePos(model, rates, 1.0, model.key_qpos[k], model.key_qpos[k + 1])
        data.qpos[:] = model.key_qpos[k]
        mujoco.mj_integratePos(model, data.qpos, rates, share)
        positions_m = model.key_mpos[k : k + 2].reshape(2, -1, 3)
        data.mocap_pos[:] = (1 - share) * positions_m[0] + share * positions_m[1]
        turns = model.key_mquat[k : k + 2].reshape(2, -1, 4)
        for n in range(model.nmocap):
            axis = np.zeros(3)
            mujoco.mju_subQuat(axis, turns[1, n], turns[0, n])
            data.mocap_quat[n] = turns[0, n]
            mujoco.mju_quatIntegrate(data.mocap_quat[n], axis, share)
