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
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt

from flybench.memory import count_memory
from sim.errors import RendererError, SceneConfigError
from sim.geometry.rectangles import image_rectangle
from sim.raster import flow
from sim.raster.visibility import VisibilityMap
from sim.render.filament import FilamentRenderer, Luminance, rendering_bytes
from sim.render.illumination import Illumination, named_illumination
from sim.render.luminance_model import luminance_model
from sim.render.model_camera import camera_id, camera_intrinsics
from sim.render.model_state import ModelState
from sim.truth.model_truth import ModelTruth

F32 = npt.NDArray[np.float32]

EXAMPLE_LIGHT = '<light type="directional" dir="0 0 -1" diffuse="1 1 1" intensity="1000"/>'
"""Example of a light, for error messages."""


class PhotometricCamera(AbstractContextManager["PhotometricCamera"]):
    """A camera of a MuJoCo model that measures luminance. Use as a context manager.

    Positions and velocities are read from the `data` passed to each method, which is not changed.
    Surfaces nearer than 5 cm or farther than 120 m are cut off.

    Attributes:
        intrinsics: image size and focal length of the model's camera.
        deforming: the model's flexes, skins, spatial tendons and slider-cranks that are rendered.
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
        light: str | Illumination | None = None,
    ) -> None:
        """Set up the renderer.

        Args:
            model: model with at least one light that has an intensity, unless `light` is given.
                Later changes to the model have no effect.
            camera: name of the camera.
            width: width of the image [px]; None: from the camera's resolution.
            height: height of the image [px]; None: from the camera's resolution.
            supersample: rendered pixels per sensor pixel and axis.
            still: True to accept a model in which nothing can move.
            light: "daylight", "overcast", "dusk", "indoor" or "night", or an `Illumination`. It
                replaces the model's lights and sky. None: the model's lights.

        Raises:
            SceneConfigError: the model has no such camera, no light, or nothing that can move; the
                camera is orthographic or has no image size; or there is no such `light`.
            RendererError: this machine has no Vulkan device.
            MemoryBudgetError: the image is too large for the memory budget.
        """
        number = camera_id(model, camera)
        illumination = None if light is None else named_illumination(light)
        if illumination is None:
            check_light(model)
        if not still:
            _check_motion(model)
        self.intrinsics = camera_intrinsics(model, camera, width=width, height=height)
        lens = self.intrinsics
        needed = rendering_bytes(lens, supersample)
        count_memory(self, f"Rendering of {lens.width}×{lens.height} px", needed)
        self._supersample, self._state = supersample, ModelState(model, number)
        grey = luminance_model(model, illumination)
        self._truth = ModelTruth(grey, self._state, self.intrinsics)
        self.deforming = self._truth.deforming
        self._renderer: FilamentRenderer | None = FilamentRenderer(
            grey, self.intrinsics, illumination
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
        pose = self._state.load(data)
        self._renderer.update(self._state.data)
        image = image_rectangle(self.intrinsics)
        return self._renderer.luminance(pose, image, supersample=self._supersample)

    def visible(self, data: mujoco.MjData) -> VisibilityMap:
        """Return what the middle of each pixel shows, and its nearness.

        It counts exactly what is rendered: geoms, sites, flexes, skins and spatial tendons of the
        groups 0 to 2 whose colour is not fully transparent, and slider-cranks. Of a translucent
        surface and what is seen through it, the surface counts.

        Returns:
            The number of the rigid body that each pixel shows; or, where it shows `deforming[k]`,
            the number of bodies of the model plus k.

        Raises:
            SceneConfigError: `data` belongs to another model; or its tendons have too many parts.
        """
        return self._truth.visible(data)

    def depth_m(self, data: mujoco.MjData) -> F32:
        """(height, width) float32 depth along the optical axis [m]; infinite for the sky."""
        return flow.depth_m(self.visible(data))

    def flow_px_s(self, data: mujoco.MjData) -> F32:
        """Return the image velocity of what the middle of each pixel shows.

        It follows from the velocities in `data.qvel`, those of the camera included. Mocap bodies
        have no velocity.

        Returns:
            (height, width, 2) float32, x and y [px/s]. NaN on a tendon in the millisecond in which
            it both begins and ceases to touch a geom.
        """
        return self._truth.flow_px_s(data)


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


def check_light(model: mujoco.MjModel) -> None:
    """Check that a model has a light with an intensity.

    Raises:
        SceneConfigError: it has none.
    """
    if not (model.light_intensity[np.asarray(model.light_active, bool)] > 0).any():
        raise SceneConfigError(
            f"none of the model's {model.nlight} lights has an intensity, so the luminance in "
            "cd/m² is 0. Allowed is at least one intensity above 0, in lux for a directional light "
            f'or in candela for a spot. Add {EXAMPLE_LIGHT}, or pass light="daylight".'
        )


def _check_motion(model: mujoco.MjModel) -> None:
    if model.nv == 0 and model.nmocap == 0:
        raise SceneConfigError(
            "nothing in the model can move, so an event camera would see only noise: it has 0 "
            "joints and 0 mocap bodies. Allowed is at least one. Add a <joint/> to a body, or pass "
            "still=True to accept this."
        )
