"""Luminance at any time from exact geometry and a few rendered keyframes.

The static background is rendered once, in layers of light (`sim.keyframes.background`). Moving
objects are scan-converted exactly at every sample (`sim.keyframes.mover_visibility`). The luminance
of their surfaces comes from the keyframes before and after (`sim.keyframes.store`), where each
point is found through the exact pose of its rigid body. Their shadows and beams fall on the
background by the geometry of the lights (`sim.shadows`). `sim.compositing.composite` combines all
of these. The image of a shaking camera is that of a steady camera, rotated
(`sim.keyframes.rotation_warp`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.cache.luminance_cache import LuminanceCache
from sim.compositing.canvas import blank_canvas, show_bodies, wipe
from sim.compositing.composite import composite
from sim.compositing.edge_pixels import aperture
from sim.compositing.pixel_labels import label_pixels
from sim.geometry.pinhole import Intrinsics, Projection
from sim.geometry.rectangles import (
    Rectangle,
    image_rectangle,
)
from sim.geometry.rigid_transform import body_poses
from sim.keyframes.background import (
    background_of,
)
from sim.keyframes.moments import Moment, Moments
from sim.keyframes.mover_visibility import MoverRaster, split_into_parts
from sim.keyframes.plan import PLAN_STEP_PX, plan_keyframes
from sim.keyframes.renderings import Renderings
from sim.keyframes.rotation_warp import SHAKE_SCALE, rotated_image
from sim.keyframes.store import KeyframeStore
from sim.motion.computed_ahead import ComputedAhead
from sim.raster.aperture import (
    LENS_BLUR_PX,
)
from sim.raster.scan_conversion import NO_LABEL, rasterise
from sim.raster.visibility import visibility_map
from sim.render.filament import Luminance
from sim.render.renderer_thread import RendererThread
from sim.scene.lamp_flicker import FlickeringLamps
from sim.scene.scene import Scene
from sim.shadows.shadows_and_beams import AffectedAreaFinder, ShadowBeamRenderer

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class RenderedSample:
    """One sample.

    Attributes:
        luminance: (height, width) float32 [cd/m²].
        body: (height, width) int32 rigid body at every pixel centre; see
            `sim.raster.visibility.VisibilityMap`.
        rectangles: areas that may differ from the static background; the whole image if the camera
            shakes.
    """

    luminance: Luminance
    body: I32
    rectangles: list[Rectangle]


class Reprojection:
    """Renders a scene at the times of a sequence, in their order."""

    def __init__(
        self,
        thread: RendererThread,
        scene: Scene,
        lens: Intrinsics,
        times_us: Sequence[int],
        seconds: Callable[[int], float],
        *,
        supersample: int,
        spacing_px: float,
        step_px: float,
        cache: LuminanceCache | None = None,
    ) -> None:
        """Render the static background and plan the keyframes.

        Args:
            thread: renderer of the scene's luminance model, with the lens from
                `sim.keyframes.rotation_warp`.
            scene: the scene: what moves, and how.
            lens: intrinsics of the camera.
            times_us: times of the samples [µs].
            seconds: converts a time [µs] to the scene's time [s].
            supersample: sub-pixels per pixel and axis.
            spacing_px: maximum displacement of an object from one keyframe to the next [px].
            step_px: maximum displacement of anything from one sample to the next [px].
            cache: where the rendered background is kept for other sequences; None: nowhere.
        """
        self._scene, model = scene, thread.model
        self._wide, self._lens, self._seconds = thread.renderer.intrinsics, lens, seconds
        self._scale = SHAKE_SCALE if scene.shake else 1
        self._supersample, self._pose = -(-supersample // self._scale), scene.pose
        self._blur_px = 0.0 if scene.shake else LENS_BLUR_PX
        self._data = mujoco.MjData(model)
        self._place(times_us[0])
        soup = scene.soup
        moving = [int(b) for o in scene.objects for b in o.bodies]
        self._movers, self._static = soup.of_bodies(moving), soup.without_bodies(moving)
        self._areas = AffectedAreaFinder(model, self._data, scene.objects, self._pose, self._wide)
        parts = split_into_parts(model, scene.objects)
        self._raster = MoverRaster(self._movers, parts, self._pose, self._wide, self._supersample)
        self._effects = ShadowBeamRenderer(model, self._movers, self._areas)
        self._flickering = (
            FlickeringLamps(scene.flickering_lights, scene.flickering_materials)
            if scene.flicker
            else None
        )
        self._aperture = aperture(self._supersample, self._blur_px)
        centre = self._wide.width / 2, self._wide.height / 2
        self._projection = Projection(self._wide.focal_px, *centre)
        plan, affected = plan_keyframes(
            scene,
            self._wide,
            self._areas,
            times_us,
            self._place,
            self._data,
            spacing_px=spacing_px * self._scale,
            stride=max(int(PLAN_STEP_PX / step_px), 1),
        )
        renderings = Renderings(
            thread, scene, seconds, self._areas, self._raster, self._static, self._flickering
        )
        light = renderings.background(affected, cache)
        data = self._data, self._pose, self._static
        size = self._supersample, self._blur_px
        self._background = background_of(light, self._wide, *data, *size)
        self._keyframes = KeyframeStore(
            plan,
            scene.objects,
            renderings.request,
            carriers=parts.body,
            per_pixel=self._supersample,
        )
        self._static_image = self._background.pixels.sum(axis=0)
        self._static_body = visibility_map(
            self._static, body_poses(self._data), self._pose, self._wide
        ).body
        self._canvas = blank_canvas(self._background)
        moments = Moments(scene, self._data, seconds, self._raster, self._areas, self._flickering)
        self._moments = ComputedAhead(moments.at, times_us)
        self._drawn: list[Rectangle] = []
        self._lit: list[Rectangle] = [image_rectangle(self._wide)]

    def render(self, t_us: int) -> RenderedSample:
        """Render the sample at a time [µs]; times must not decrease."""
        self._keyframes.advance(t_us)
        now = self._moments.at(t_us)
        sample = self._steady_sample(t_us, now)
        if self._scene.shake is None:
            return sample
        pose = self._scene.pose_at(self._seconds(t_us))
        luminance = rotated_image(sample.luminance, self._pose, self._wide, pose, self._lens)
        visible = visibility_map(self._static, now.poses, pose, self._lens)
        body = visibility_map(self._movers, now.poses, pose, self._lens, visible).body
        return RenderedSample(luminance, body, [image_rectangle(self._lens)])

    def _steady_sample(self, t_us: int, now: Moment) -> RenderedSample:
        """Return what the steady camera sees."""
        canvas, background, body = self._canvas, self._background, self._static_body.copy()
        if self._flickering is None:
            for x0, y0, x1, y1 in self._lit:
                canvas.image[y0:y1, x0:x1] = self._static_image[y0:y1, x0:x1]
        else:
            canvas.image[:] = np.tensordot(now.gains.astype(np.float32), background.pixels, axes=1)
        self._draw_outlines(now, body)
        self._lit = now.changed
        if now.changed:
            effects = self._effects.render(now.poses, now.affected, now.gains)
            surfaces = self._keyframes.surfaces(t_us, now.views, now.flicker, self._projection)
            moving = effects, surfaces, self._projection, self._aperture
            for rectangle in now.changed:
                composite(canvas, background, *moving, rectangle)
        whole = [image_rectangle(self._wide)]
        changed = now.changed if self._flickering is None else whole
        return RenderedSample(canvas.image.copy(), body, changed)

    def _draw_outlines(self, now: Moment, body: I32) -> None:
        """Put the moving parts on the canvas, and their bodies into a map of pixel centres."""
        canvas, size = self._canvas, self._supersample
        for rectangle in self._drawn:
            wipe(canvas, self._background, rectangle, size)
        self._drawn = now.drawn
        if now.drawn:
            rasterise(now.triangles, now.part, 0, 0, canvas.nearness, canvas.label, True)
        for x0, y0, x1, y1 in now.changed:
            canvas.pixel_label[y0:y1, x0:x1] = NO_LABEL
        for rectangle in now.drawn:
            show_bodies(canvas.label, self._raster.parts.body, size, rectangle, body)
            label_pixels(canvas.label, size, rectangle, canvas.pixel_label)

    def _place(self, t_us: int) -> None:
        self._scene.place(self._data, self._seconds(t_us))
