"""The poses of a model and its camera, computed from the state of a simulation."""

from __future__ import annotations

import mujoco

from sim.errors import SceneConfigError
from sim.geometry.pinhole import Pose


def update_poses(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Compute the poses of bodies, cameras, lights, flexes and tendons from the positions."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
    mujoco.mj_flex(model, data)
    mujoco.mj_tendon(model, data)


class ModelState:
    """Poses of a model and its camera, in data of its own.

    Attributes:
        data: the poses last loaded.
    """

    def __init__(self, model: mujoco.MjModel, camera: int) -> None:
        """Prepare the data.

        Args:
            model: the model.
            camera: number of the camera.
        """
        self._model, self._camera = model, camera
        self.data = mujoco.MjData(model)

    def load(self, data: mujoco.MjData, ahead_s: float = 0.0) -> Pose:
        """Compute all poses from the joint positions in `data`, moved on by `ahead_s`.

        The poses in `data` cannot be used: after `mj_step` they are those of the step before.

        Returns:
            The pose of the camera.

        Raises:
            SceneConfigError: `data` belongs to another model.
        """
        own = self.data
        if data.qpos.shape != own.qpos.shape:
            raise SceneConfigError(
                f"data has {data.qpos.size} positions. Allowed is {own.qpos.size}, as in "
                "the camera's model. Make the data with mujoco.MjData(model)."
            )
        own.qpos[:] = data.qpos
        own.mocap_pos[:], own.mocap_quat[:] = data.mocap_pos, data.mocap_quat
        mujoco.mj_integratePos(self._model, own.qpos, data.qvel, ahead_s)
        update_poses(self._model, own)
        axes = own.cam_xmat[self._camera].reshape(3, 3)
        position_m = own.cam_xpos[self._camera].copy()
        return Pose(position_m, right=axes[:, 0].copy(), up=axes[:, 1].copy())
