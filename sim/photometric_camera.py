"""The photometric camera on any MuJoCo model: what one of its cameras sees, in cd/m².

Light is what the model says: an intensity is lux for a directional light, candela for a point or
spot light and cd/m² for an image light, times the light's diffuse colour, which must be 1 1 1 for
the figure to be taken as it stands (MuJoCo's own default is 0.7). A reflectance is a material's
rgba times its texture; the rgba is taken as sRGB unless the model has the text
"filament.material.base_color_type" of the value "linear", the texture as linear unless its
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
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.raster import flow
from sim.raster.triangles import TriangleSoup, triangle_soup
from sim.raster.visibility import VisibilityMap, visibility_map
from sim.render.filament import FilamentRenderer, Luminance
from sim.render.luminance_model import luminance_model
from sim.render.model_camera import camera_intrinsics, camera_number
from sim.truth.dense_truth import RATE_STEP_S

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

A_LIGHT = '<light type="directional" dir="0 0 -1" diffuse="1 1 1" intensity="1000"/>'


class PhotometricCamera(AbstractContextManager["PhotometricCamera"]):
    """A camera of a MuJoCo model that reads luminance; use as a context manager.

    What `data` says of positions and velocities is read, and nothing in it is changed. Surfaces
    nearer than 5 cm or farther than 120 m are cut off.

    Attributes:
        intrinsics: size and focal length, from the model's camera.
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
            model: with at least one light of an intensity; later changes to it are not seen.
            camera: its name.
            width: of the image [px]; None: the model's resolution.
            height: likewise.
            supersample: rendered pixels per pixel and axis.
            still: accept a model in which nothing can move.

        Raises:
            SceneConfigError: no such camera; one that is not central or has no size; no light;
                nothing that can move.
            RendererError: no Vulkan device.
        """
        self._number = camera_number(model, camera)
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
        """Free the device's memory; no luminance can be read afterwards."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def luminance(self, data: mujoco.MjData) -> Luminance:
        """The mean over each pixel, behind a lens's blur of a third of a pixel.

        Returns:
            (height, width) float32 [cd/m²].

        Raises:
            RendererError: the camera is closed, or the device was lost.
            SceneConfigError: `data` is of another model.
        """
        if self._renderer is None:
            raise RendererError(
                "the photometric camera is closed; allowed is to read it before; read it inside "
                "of its with block, or make another"
            )
        self._take(data)
        self._renderer.update(self._data)
        whole = (0, 0, self.intrinsics.width, self.intrinsics.height)
        return self._renderer.luminance(self._pose(), whole, supersample=self._supersample)

    def visible(self, data: mujoco.MjData) -> VisibilityMap:
        """Which rigid body each pixel's middle shows, and how near.

        Raises:
            SceneConfigError: the model has a geom without triangles, such as a height field; or
                `data` is of another model.
        """
        self._take(data)
        return visibility_map(self._soup, body_poses(self._data), self._pose(), self.intrinsics)

    def depth_m(self, data: mujoco.MjData) -> F32:
        """(height, width) float32 depth along the optical axis [m]; infinite for the sky."""
        return flow.depth_m(self.visible(data))

    def flow_px_s(self, data: mujoco.MjData) -> F32:
        """Velocity in the image of what each pixel's middle shows.

        That which follows from `data.qvel`, the camera's own included; a mocap body has none.

        Returns:
            (height, width, 2) float32, x and y [px/s].
        """
        before, now, after = (self._views(data, step) for step in (-RATE_STEP_S, 0.0, RATE_STEP_S))
        twists = flow.twists_between(before, now, after, 2 * RATE_STEP_S)
        return flow.flow_px_s(self.visible(data), twists, self.intrinsics)

    @cached_property
    def _soup(self) -> TriangleSoup:
        return triangle_soup(self._model)

    def _views(self, data: mujoco.MjData, ahead_s: float) -> F64:
        """(bodies, 3, 4) from each body's frame into the camera's, a little later."""
        self._take(data, ahead_s)
        return compose_transforms(body_poses(self._data), self._pose().into)

    def _take(self, data: mujoco.MjData, ahead_s: float = 0.0) -> None:
        """Work out where everything is; after `mj_step`, `data` itself is one step late."""
        if data.qpos.shape != self._data.qpos.shape:
            raise SceneConfigError(
                f"the data has {data.qpos.size} positions; allowed is the {self._data.qpos.size} "
                "of the camera's model; make it with mujoco.MjData(model)"
            )
        mine = self._data
        mine.qpos[:] = data.qpos
        mine.mocap_pos[:], mine.mocap_quat[:] = data.mocap_pos, data.mocap_quat
        mujoco.mj_integratePos(self._model, mine.qpos, data.qvel, ahead_s)
        mujoco.mj_kinematics(self._model, mine)
        mujoco.mj_comPos(self._model, mine)
        mujoco.mj_camlight(self._model, mine)

    def _pose(self) -> Pose:
        axes = self._data.cam_xmat[self._number].reshape(3, 3)
        place = self._data.cam_xpos[self._number].copy()
        return Pose(place, right=axes[:, 0].copy(), up=axes[:, 1].copy())


def open_model(path: str | Path) -> mujoco.MjModel:
    """Compile an MJCF file, its textures and meshes included.

    Raises:
        SceneConfigError: it, or a file that it names, is missing or damaged.
    """
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except (ValueError, FileNotFoundError) as error:
        why = " ".join(str(error).split()) or type(error).__name__
        raise SceneConfigError(
            f"cannot open {path}: {why}; allowed is an MJCF file whose textures and meshes are "
            "where it says; mend the path, or put the file there"
        ) from error


def _check_light(model: mujoco.MjModel) -> None:
    if not (model.light_intensity[np.asarray(model.light_active, bool)] > 0).any():
        raise SceneConfigError(
            f"none of the model's {model.nlight} lights has an intensity, so that there is no "
            "light in cd/m²; allowed is one or more above 0, in lux for a directional light and "
            f"candela for a spot; add {A_LIGHT}"
        )


def _check_motion(model: mujoco.MjModel) -> None:
    if model.nv == 0 and model.nmocap == 0:
        raise SceneConfigError(
            "nothing in the model can move: it has 0 joints and 0 mocap bodies, and an event "
            "camera would see noise alone; allowed is one or more; add a <joint/> to a body, or "
            "pass still=True if that is what you want"
        )
