"""A photometric camera for any MuJoCo model: the luminance that one of its cameras sees, in cd/m².

The intensity of a light is in lux for a directional light, in candela for a point or spot light,
and in cd/m² for an image light. It is multiplied by the light's diffuse colour, so set the diffuse
colour to 1 1 1 to get the stated intensity (MuJoCo's default is 0.7). The reflectance of a surface
is the rgba of its material times its texture. The rgba is sRGB unless the model has the custom text
"filament.material.base_color_type" with the value "linear". A texture is linear unless its
colorspace is sRGB.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt

from sim.errors import RendererError, SceneConfigError
from sim.geometry.pinhole import Pose
from sim.geometry.rectangles import image_rectangle
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.raster import flow
from sim.raster.triangles import TriangleSoup, triangle_soup
from sim.raster.visibility import VisibilityMap, visibility_map
from sim.render.filament import FilamentRenderer, Luminance
from sim.render.luminance_model import luminance_model
from sim.render.model_camera import camera_id, camera_intrinsics
from sim.truth.dense_truth import RATE_STEP_S

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

EXAMPLE_LIGHT = '<light type="directional" dir="0 0 -1" diffuse="1 1 1" intensity="1000"/>'
"""Example of a light, for error messages."""


class PhotometricCamera(AbstractContextManager["PhotometricCamera"]):
    """A camera of a MuJoCo model that measures luminance. Use as a context manager.

    Positions and velocities are read from the `data` passed to each method, which is not changed.
    Surfaces nearer than 5 cm or farther than 120 m are cut off.

    Attributes:
        intrinsics: image size and focal length of the model's camera.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        camera: str,
        *,
        width: int | None = None,
        height: int | None = None,
        supersample: int = 2,
        still: bool = False,
    ) -> None:
        """Set up the renderer.

        Args:
            model: model with at least one light that has an intensity. Later changes to the model
                have no effect.
            camera: name of the camera.
            width: width of the image [px]; None: from the camera's resolution.
            height: height of the image [px]; None: from the camera's resolution.
            supersample: rendered pixels per sensor pixel and axis.
            still: True to accept a model in which nothing can move.

        Raises:
            SceneConfigError: the model has no such camera, no light, or nothing that can move; or
                the camera is not a central pinhole or has no image size.
            RendererError: this machine has no Vulkan device.
        """
        self._camera = camera_id(model, camera)
        _check_light(model)
        if not still:
            _check_motion(model)
        self.intrinsics = camera_intrinsics(model, camera, width=width, height=height)
        self._model, self._supersample = model, supersample
        self._data = mujoco.MjData(model)
        self._renderer: FilamentRenderer | None = FilamentRenderer(
            luminance_model(model), self.intrinsics
        )

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the device's memory. No luminance can be read afterwards."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def luminance(self, data: mujoco.MjData) -> Luminance:
        """Render the mean luminance of each pixel, after a lens blur of a third of a pixel.

        Returns:
            (height, width) float32 [cd/m²].

        Raises:
            RendererError: the camera is closed, or the device was lost.
            SceneConfigError: `data` belongs to another model.
        """
        if self._renderer is None:
            raise RendererError(
                "The photometric camera is closed. Allowed is reading before it is closed. Read "
                "the luminance inside the camera's with block, or make a new camera."
            )
        self._load_state(data)
        self._renderer.update(self._data)
        image = image_rectangle(self.intrinsics)
        return self._renderer.luminance(self._pose(), image, supersample=self._supersample)

    def visible(self, data: mujoco.MjData) -> VisibilityMap:
        """Return the rigid body that the middle of each pixel shows, and its nearness.

        Raises:
            SceneConfigError: the model has a geom without triangles, such as a height field; or
                `data` belongs to another model.
        """
        self._load_state(data)
        return visibility_map(self._soup, body_poses(self._data), self._pose(), self.intrinsics)

    def depth_m(self, data: mujoco.MjData) -> F32:
        """(height, width) float32 depth along the optical axis [m]; infinite for the sky."""
        return flow.depth_m(self.visible(data))

    def flow_px_s(self, data: mujoco.MjData) -> F32:
        """Return the image velocity of what the middle of each pixel shows.

        It follows from the velocities in `data.qvel`, those of the camera included. Mocap bodies
        have no velocity.

        Returns:
            (height, width, 2) float32, x and y [px/s].
        """
        before, now, after = (
            self._poses_in_camera(data, ahead_s) for ahead_s in (-RATE_STEP_S, 0.0, RATE_STEP_S)
        )
        twists = flow.twists_between(before, now, after, 2 * RATE_STEP_S)
        return flow.flow_px_s(self.visible(data), twists, self.intrinsics)

    @cached_property
    def _soup(self) -> TriangleSoup:
        return triangle_soup(self._model)

    def _poses_in_camera(self, data: mujoco.MjData, ahead_s: float) -> F64:
        """(bodies, 3, 4) transforms from each body's frame to the camera's, `ahead_s` later."""
        self._load_state(data, ahead_s)
        return compose_transforms(body_poses(self._data), self._pose().world_to_camera)

    def _load_state(self, data: mujoco.MjData, ahead_s: float = 0.0) -> None:
        """Compute all poses from the joint positions in `data`, moved on by `ahead_s`.

        The poses in `data` cannot be used: after `mj_step` they are those of the step before.
        """
        if data.qpos.shape != self._data.qpos.shape:
            raise SceneConfigError(
                f"data has {data.qpos.size} positions. Allowed is {self._data.qpos.size}, as in "
                "the camera's model. Make the data with mujoco.MjData(model)."
            )
        own = self._data
        own.qpos[:] = data.qpos
        own.mocap_pos[:], own.mocap_quat[:] = data.mocap_pos, data.mocap_quat
        mujoco.mj_integratePos(self._model, own.qpos, data.qvel, ahead_s)
        mujoco.mj_kinematics(self._model, own)
        mujoco.mj_comPos(self._model, own)
        mujoco.mj_camlight(self._model, own)

    def _pose(self) -> Pose:
        axes = self._data.cam_xmat[self._camera].reshape(3, 3)
        position_m = self._data.cam_xpos[self._camera].copy()
        return Pose(position_m, right=axes[:, 0].copy(), up=axes[:, 1].copy())


def open_model(path: str | Path) -> mujoco.MjModel:
    """Compile an MJCF file with its textures and meshes.

    Raises:
        SceneConfigError: the file, or a file that it names, is missing or damaged.
    """
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except (ValueError, FileNotFoundError) as error:
        why = " ".join(str(error).split()) or type(error).__name__
        raise SceneConfigError(
            f"cannot open {path}: {why.rstrip('.')}. Allowed is an MJCF file whose textures and "
            "meshes are where it names them. Correct the path, or put the missing file there."
        ) from error


def _check_light(model: mujoco.MjModel) -> None:
    if not (model.light_intensity[np.asarray(model.light_active, bool)] > 0).any():
        raise SceneConfigError(
            f"none of the model's {model.nlight} lights has an intensity, so the luminance in "
            "cd/m² is 0. Allowed is at least one intensity above 0, in lux for a directional light "
            f"or in candela for a spot. Add {EXAMPLE_LIGHT}."
        )


def _check_motion(model: mujoco.MjModel) -> None:
    if model.nv == 0 and model.nmocap == 0:
        raise SceneConfigError(
            "nothing in the model can move, so an event camera would see only noise: it has 0 "
            "joints and 0 mocap bodies. Allowed is at least one. Add a <joint/> to a body, or pass "
            "still=True to accept this."
        )
