"""Everything that is rendered for a sequence: its background, and its keyframes on request.

The renderer works in a thread of its own; see `sim.render.renderer_thread`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace

import mujoco
import numpy as np

from sim.cache.key import background_key
from sim.cache.luminance_cache import LuminanceCache
from sim.geometry.rectangles import Rectangle, enclosing_rectangle, rectangle_around
from sim.keyframes.background import background_nearness
from sim.keyframes.background_layers import BackgroundLight, render_light
from sim.keyframes.mover_visibility import MoverRaster
from sim.keyframes.plan import PLAN_STEP_PX
from sim.keyframes.rendering import KeyframeRenderer
from sim.keyframes.store import Keyframe
from sim.raster.aperture import blur_before_interpolation_px
from sim.raster.triangles import TriangleSoup
from sim.render.renderer_thread import RendererThread
from sim.scene.lamp_flicker import FlickeringLamps, changed_lights
from sim.scene.moving_objects import MovingObject
from sim.scene.scene import Scene
from sim.shadows.shadows_and_beams import AffectedAreaFinder

SHAKE_OVERSAMPLE = 2
"""Rendered samples per sub-pixel and axis in the background of a shaking camera. An edge that is
slightly misplaced causes events much too late, because shake moves the image slowly (measured
against 16×16: of the events by day, 87 % instead of 82 % match within 2 ms)."""
KEYFRAME_OVERSAMPLE = 2
"""Rendered samples per sub-pixel and axis in the keyframes of a steady camera. Without it, a line
about as thin as a sub-pixel is too wide or missing as long as the keyframe is used (measured
against 6×6 in 55 pieces: 86 % instead of 83 % match within 0.2 ms, and the error in the number of
events is 1.4 % instead of 1.9 %). The keyframes of a shaking camera are not oversampled: their lens
blur is applied later, so that the blur of averaging and of interpolation cannot be subtracted from
it."""


class Renderings:
    """The rendered images of one sequence."""

    def __init__(
        self,
        thread: RendererThread,
        scene: Scene,
        seconds: Callable[[int], float],
        areas: AffectedAreaFinder,
        raster: MoverRaster,
        static: TriangleSoup,
        flickering: FlickeringLamps | None,
    ) -> None:
        """Prepare; nothing is rendered yet.

        Args:
            thread: renderer of the scene's luminance model for a steady camera. It changes the
                lights of the model temporarily.
            scene: the scene.
            seconds: converts a time [µs] to the scene's time [s].
            areas: lights whose shadows and beams move.
            raster: rasteriser of the moving objects at the samples' resolution.
            static: triangles of the static objects.
            flickering: lamps that flicker; None if there are none.
        """
        model = thread.model
        self._thread, self._model, self._scene, self._areas = thread, model, scene, areas
        self._raster, self._flickering = raster, flickering
        self._data = data = mujoco.MjData(model)  # used by the thread only
        scene.place(data, 0.0)
        lens, per_pixel, shakes = raster.lens, raster.supersample, scene.shake is not None
        supersample = per_pixel * (1 if shakes else KEYFRAME_OVERSAMPLE)
        self._keyframes = KeyframeRenderer(
            thread.renderer,
            model,
            data,
            lambda t_us: scene.place(data, seconds(t_us)),
            replace(raster, supersample=supersample),
            scene.objects,
            flickering,
            background_nearness(lens, data, raster.pose, static, supersample),
            0.0 if shakes else blur_before_interpolation_px(per_pixel),
            per_pixel,
        )

    def request(self, obj: MovingObject, t_us: int) -> Future[Keyframe]:
        """Ask for an object's keyframe at a time [µs]."""
        return self._thread.submit(self._keyframes.render, obj, t_us)

    def background(
        self, affected: list[Rectangle], cache: LuminanceCache | None
    ) -> BackgroundLight:
        """Return the light on the scene without its moving objects, from the cache if it has it.

        Args:
            affected: areas that shadows and beams can reach. Elsewhere, lights are not separated.
            cache: where the light is kept for other sequences of the same street; None: nowhere.
        """
        spare, span = math.ceil(2 * PLAN_STEP_PX), np.array(enclosing_rectangle(affected))
        around = rectangle_around(span[:2] - spare, span[2:] + spare, self._raster.lens)
        rectangle = around or (0, 0, 1, 1)
        oversample = SHAKE_OVERSAMPLE if self._scene.shake else 1

        def render() -> BackgroundLight:
            return self._thread.submit(self._render_light, rectangle, oversample).result()

        if cache is None:
            return render()
        key = background_key(
            self._scene.config,
            self._raster.lens,
            self._raster.pose,
            rectangle=rectangle,
            supersample=self._raster.supersample,
            oversample=oversample,
            with_albedo=bool(self._areas.beams.size),
        )
        return BackgroundLight.from_bytes(cache.get_or_make(key, lambda: render().to_bytes()))

    def _render_light(self, rectangle: Rectangle, oversample: int) -> BackgroundLight:
        """Render the scene without its moving objects; called in the renderer's thread."""
        renderer, objects = self._thread.renderer, self._scene.objects
        geoms = [int(g) for o in objects for g in o.geoms]
        off = {int(k): 0.0 for k in self._areas.beams}
        bodies = np.concatenate([o.bodies for o in objects])
        sites = np.flatnonzero(np.isin(self._model.site_bodyid, bodies))  # they mark the lamps
        with changed_lights(self._model, off), renderer.hidden(geoms, sites):
            return render_light(
                renderer,
                self._model,
                self._data,
                self._raster.pose,
                self._areas.shadow_lights,
                self._flickering,
                rectangle,
                self._raster.supersample,
                oversample,
                with_albedo=bool(self._areas.beams.size),
            )
