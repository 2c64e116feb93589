"""MuJoCo's Filament renderer, with images in cd/m².

Filament writes luminance × exposure as linear float32 into the red channel. It renders a model from
`sim.render.luminance_model`, in which every colour is a grey of the same luminance. A rectangle of
a luminance image is rendered with the frustum of the whole image, so that its pixels show what they
would show in the whole image.
"""

from __future__ import annotations

import os
import weakref
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import mujoco
import mujoco.studio.window  # registers Filament's material assets
import numpy as np
import numpy.typing as npt
from mujoco import mjrf

from sim.errors import RendererError
from sim.geometry.pinhole import NEAR_M, Intrinsics, Pose
from sim.geometry.rectangles import Rectangle, image_rectangle
from sim.raster.aperture import BLUR_REACH_PX, to_pixels
from sim.render.draw_order import DrawOrder
from sim.render.entities import reserve_entities
from sim.render.free_memory import return_free_memory
from sim.render.illumination import Illumination
from sim.render.luminance_model import has_linear_colours
from sim.render.model_state import update_poses
from sim.render.quiet_output import suppress_output
from sim.render.sky_and_sun import SkyAndSun, neutral_options
from sim.render.vulkan import require_vulkan

EXPOSURE = 2.604e-5
"""Factor that Filament applies to luminance at its default exposure (f/16, 1/125 s, ISO 100)."""
FAR_M = 120.0
"""Distance of the far clipping plane, beyond both ends of the street [m] (assumed)."""

_BYTES_PER_PX = 100
"""Memory of a crossing per rendered pixel (measured: 68 at 8×8 sub-pixels, 98 at 1280×720 px)
[bytes]."""

Luminance = npt.NDArray[np.float32]
Span = tuple[float, float, float, float]
"""x0, y0, x1, y1 of a rectangle of the image, not necessarily of whole pixels [px]."""


def rendering_bytes(intrinsics: Intrinsics, supersample: int) -> int:
    """Return the memory that images of this size need, without that of scene and driver [bytes].

    Args:
        intrinsics: lens and sensor.
        supersample: rendered pixels per sensor pixel and axis.
    """
    return _BYTES_PER_PX * intrinsics.width * intrinsics.height * (supersample**2 + 1)


class FilamentRenderer:
    """Renders one model from any pose. Use as a context manager.

    Attributes:
        intrinsics: lens and sensor.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        intrinsics: Intrinsics,
        illumination: Illumination | None = None,
    ) -> None:
        """Set up the renderer.

        Args:
            model: model with photometric lights; see `sim.render.luminance_model`.
            intrinsics: lens and sensor.
            illumination: light that replaces the model's lights and rendering options; None: these.

        Raises:
            RendererError: this machine has no Vulkan device, or too many renderers are open.
        """
        software = require_vulkan()
        self.intrinsics = intrinsics
        self._entities = reserve_entities(model)
        weakref.finalize(self, self._entities.release)
        with suppress_output():
            self._context = mjrf.Context(_context_config(software))
        self._context.set_clear_color([0.0, 0.0, 0.0])
        self._scene = self._context.create_scene(mjrf.SceneParams())
        self._resources = mjrf.ModelResources(self._context, model)
        if illumination is None:
            self._scene.configure_from_model(model)
            self._lights: Any = mjrf.ModelLights(self._scene, self._resources)
        else:
            linear = has_linear_colours(model)
            self._scene.configure_from_model(neutral_options(linear_colours=linear))
            self._lights = SkyAndSun(self._context, self._scene, illumination)
        self._renderables = mjrf.ModelRenderables(self._scene, self._resources)
        data = mujoco.MjData(model)
        update_poses(model, data)  # without poses, a skin or flex crashes the first update
        self._renderables.update(data)  # creates them
        self._draw_order = DrawOrder(self._context, self._resources, model)
        self._targets: dict[Any, Any] = {}

    def __enter__(self) -> FilamentRenderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the device's memory. The renderer cannot be used afterwards."""
        with suppress_output():
            for name in (
                "_targets",
                "_draw_order",
                "_renderables",
                "_lights",
                "_resources",
                "_scene",
                "_context",
            ):
                setattr(self, name, None)
        self._entities.release()
        return_free_memory()

    def update(self, data: mujoco.MjData) -> None:
        """Move geoms and lights to their poses in `data`, whose kinematics must be up to date."""
        self._lights.update(data)
        self._renderables.update(data)
        self._draw_order.update(data)

    def luminance(self, pose: Pose, rectangle: Rectangle, *, supersample: int = 2) -> Luminance:
        """Render the anti-aliased luminance of a rectangle of the image.

        Each value is the mean over the area of the pixel, after the blur of the lens.

        Args:
            pose: pose of the camera.
            rectangle: pixels to render.
            supersample: rendered pixels per sensor pixel and axis.

        Returns:
            (y1 - y0, x1 - x0) float32 [cd/m²].
        """
        outer = self._with_blur_margin(rectangle)
        pixels = to_pixels(self.subpixel_luminance(pose, outer, supersample), supersample)
        x, y = rectangle[0] - outer[0], rectangle[1] - outer[1]
        inner = pixels[y : y + rectangle[3] - rectangle[1], x : x + rectangle[2] - rectangle[0]]
        return np.ascontiguousarray(inner)

    def subpixel_luminance(
        self,
        pose: Pose,
        rectangle: Rectangle,
        supersample: int,
        *,
        shadows: bool = True,
        skybox: bool = True,
    ) -> Luminance:
        """Render the luminance on the sub-pixel grid of a rectangle of the image, unfiltered.

        Args:
            pose: pose of the camera.
            rectangle: pixels to render.
            supersample: grid points per pixel and axis.
            shadows: True to render shadows.
            skybox: True to show the sky where nothing else is; otherwise it is 0 there.

        Returns:
            ((y1 - y0) · supersample, (x1 - x0) · supersample) float32 [cd/m²].
        """
        grey = mjrf.PixelFormat.PIXEL_FORMAT_R32F
        exposed = self._render(pose, rectangle, supersample, grey, shadows=shadows, skybox=skybox)
        return np.asarray(exposed / np.float32(EXPOSURE), np.float32)

    @contextmanager
    def hidden(self, geoms: Iterable[int], sites: Iterable[int] = ()) -> Iterator[None]:
        """Leave geoms, sites and their shadows out of every image rendered in the with block."""
        kind = mujoco.mjtObj
        renderables = [self._renderable(kind.mjOBJ_GEOM, geom) for geom in geoms]
        renderables += [self._renderable(kind.mjOBJ_SITE, site) for site in sites]
        for renderable in renderables:
            self._scene.remove_renderable(renderable)
        try:
            yield
        finally:
            for renderable in renderables:
                self._scene.add_renderable(renderable)

    def _renderable(self, kind: mujoco.mjtObj, number: int) -> Any:
        return self._renderables.get_renderable(kind, int(number), -1)

    def segmentation(self, pose: Pose, rectangle: Rectangle) -> npt.NDArray[np.int32]:
        """Render the number of the geom that the middle of each pixel shows.

        Args:
            pose: pose of the camera.
            rectangle: pixels to render.

        Returns:
            (y1 - y0, x1 - x0) int32 geom numbers, -1 for none.
        """
        rgb = self._render(
            pose,
            rectangle,
            1,
            mjrf.PixelFormat.PIXEL_FORMAT_RGB8,
            draw_mode=mjrf.DrawMode.DRAW_MODE_SEGMENTATION_BY_ID,
        ).astype(np.int32)
        return rgb[..., 0] + 256 * rgb[..., 1] + 65536 * rgb[..., 2] - 1

    def preview(self, pose: Pose, area: Rectangle, scale: float) -> npt.NDArray[np.uint8]:
        """Render an area of a tone-mapped colour image.

        Args:
            pose: pose of the camera.
            area: x0, y0, x1, y1 of the area [px of the colour image].
            scale: pixels of the colour image per sensor pixel and axis.

        Returns:
            (y1 - y0, x1 - x0, 3) uint8 sRGB.
        """
        x0, y0, x1, y1 = area
        rectangle = x0 / scale, y0 / scale, x1 / scale, y1 / scale
        rgb = mjrf.PixelFormat.PIXEL_FORMAT_RGB8
        return self._render(pose, rectangle, scale, rgb, post_processing=True)

    def _with_blur_margin(self, rectangle: Rectangle) -> Rectangle:
        m, i = BLUR_REACH_PX, self.intrinsics
        x0, y0, x1, y1 = rectangle
        return max(x0 - m, 0), max(y0 - m, 0), min(x1 + m, i.width), min(y1 + m, i.height)

    def _render(
        self, pose: Pose, rectangle: Span, scale: float, pixel_format: Any, **options: Any
    ) -> npt.NDArray[Any]:
        height = round((rectangle[3] - rectangle[1]) * scale)
        width = round((rectangle[2] - rectangle[0]) * scale)
        is_colour = pixel_format == mjrf.PixelFormat.PIXEL_FORMAT_RGB8
        if is_colour:
            image: npt.NDArray[Any] = np.empty((height, width, 3), np.uint8)
        else:
            image = np.empty((height, width), np.float32)
            image[0, 0] = np.nan  # remains NaN if the device delivers no frame
        target = self._target(pixel_format, bool(options.get("post_processing")))
        target.resize(width, height)
        read = mjrf.ReadRequest(target=target)
        read.set_buffer(image)
        request = self._request(pose, rectangle, scale, target, **options)
        try:
            requests = self._draw_order.requests(request)
            self._context.wait_for_frame(self._context.render(requests, [read]))
        except RuntimeError as error:
            raise RendererError(_DEVICE_LOST) from error
        self._entities.note_image()
        if not is_colour and np.isnan(image[0, 0]):
            raise RendererError(_DEVICE_LOST)
        return image

    def _target(self, pixel_format: Any, post_processing: bool) -> Any:
        key = (pixel_format, post_processing)
        if key not in self._targets:
            config = mjrf.RenderTargetConfig(color_format=pixel_format)
            self._targets[key] = self._context.create_render_target(config)
        return self._targets[key]

    def _request(
        self, pose: Pose, rectangle: Span, scale: float, target: Any, **options: Any
    ) -> Any:
        request = mjrf.RenderRequest()
        request.scene, request.target = self._scene, target
        image = image_rectangle(self.intrinsics)
        # A viewport beyond the target keeps the bits of the whole image. Post-processing needs one
        # that is the target.
        seen = rectangle if options.get("post_processing") else image
        request.camera = _frustum(pose, self.intrinsics, seen)
        request.viewport.left = round((seen[0] - rectangle[0]) * scale)
        request.viewport.bottom = round((rectangle[3] - seen[3]) * scale)
        request.viewport.width = round((seen[2] - seen[0]) * scale)
        request.viewport.height = round((seen[3] - seen[1]) * scale)
        request.post_processing = False
        request.haze = request.reflections = request.headlight = False
        for name, value in options.items():
            setattr(request, name, value)
        return request


_DEVICE_LOST = (
    "the Vulkan device delivered no frame and seems to be lost. Rendering needs a device that "
    "responds. Run the command again; if it fails again, check the driver with `flybench doctor`."
)


def _context_config(software: bool) -> Any:
    vulkan = mjrf.GraphicsApi.GRAPHICS_API_VULKAN
    default = mjrf.GraphicsApi.GRAPHICS_API_DEFAULT
    api = vulkan if os.uname().sysname == "Linux" else default
    return mjrf.ContextConfig(graphics_api=api, software_rendering=software)


def _frustum(pose: Pose, intrinsics: Intrinsics, rectangle: Span) -> Any:
    """Return the camera that sees a rectangle of the image."""
    focal_x, focal_y = intrinsics.focal_px, intrinsics.focal_px * intrinsics.aspect
    x0, y0, x1, y1 = rectangle
    above, middle = intrinsics.centre_px[1], (x0 + x1) / 2 - intrinsics.width / 2
    return mjrf.Camera(
        pos=pose.position_m.astype(np.float32),
        forward=pose.forward.astype(np.float32),
        up=pose.up.astype(np.float32),
        frustum_bottom=NEAR_M * (above - y1) / focal_y,
        frustum_top=NEAR_M * (above - y0) / focal_y,
        frustum_center=NEAR_M * (middle - intrinsics.axis_px[0]) / focal_x,
        frustum_near=NEAR_M,
        frustum_far=FAR_M,
        frustum_width=NEAR_M * (x1 - x0) / 2 / focal_x,
    )
