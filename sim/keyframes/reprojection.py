"""Light at any time from few drawings: geometry anew at every sample, surfaces from keyframes.

What never moves is drawn once, light by light (`sim.keyframes.background`). What moves is
scan-converted exactly at every sample (`sim.raster.scan_conversion`); its surfaces' luminance comes
from the keyframes before and after (`sim.keyframes.store`), found there through the exact pose of
each rigid body; its shadows and beams fall on the street by the geometry of its lights
(`sim.shadows.moving_light`). `sim.keyframes.compositing` puts these together. A camera that shakes
sees the image that it would see at rest, turned.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import Eye, Intrinsics, project
from sim.geometry.rectangles import Rectangle, hull, merged, rectangle_around
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.keyframes.background import Background, render_background, street_nearness
from sim.keyframes.compositing import compose
from sim.keyframes.mover_visibility import Outlines, parts
from sim.keyframes.rendering import KeyframeDrawing
from sim.keyframes.rotation_warp import rotated_image
from sim.keyframes.steady_lens import SHAKE_SCALE
from sim.keyframes.store import KeyframeStore, keyframe_times
from sim.raster.aperture import (
    LENS_BLUR_PX,
    aperture_weights,
    blur_before_interpolation_px,
)
from sim.raster.triangles import triangle_soup
from sim.raster.visibility import Visible, look, show_middles
from sim.render.filament import FilamentRenderer, Luminance
from sim.scene.lamp_flicker import FlickeringLamps, changed_lights
from sim.scene.scene import Scene
from sim.shadows.moving_light import LightReach, MovingLight

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]

PLAN_STEP_PX = 4.0
"""How far things may move between the times at which reach and keyframes are planned [px]
(assumed)."""
LIMBS_KEYFRAME_US = 100_000
"""Boughs and limbs that swing get a keyframe as often as this, however little the whole moves
(assumed)."""
SHAKE_FINER = 2
"""Points along each axis of which each of these is the mean, in the still street: an edge a little
off its place comes long after its time where the image moves as slowly as in a shake (measured
against 16×16: of the events by day 87 instead of 82 % match within 2 ms)."""
KEYFRAME_FINER = 2
"""The same, of the keyframes of a camera at rest: a line about as thin as a point is drawn too wide
or not at all for as long as they last (measured against 6×6 in 55 pieces: 86 instead of 83 % match
within 0.2 ms, and the error in number is 1.4 instead of 1.9 %). If it shakes, no lens's blur is yet
in them that this mean and interpolation could be taken off."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """One sample.

    Attributes:
        luminance: (height, width) float32 [cd/m²].
        visible: what each pixel's middle shows.
        rectangles: what may differ from the still street; the whole image where the camera shakes.
    """

    luminance: Luminance
    visible: Visible
    rectangles: list[Rectangle]


class Reprojection:
    """Draws a scene at the times of a sequence, in their order."""

    def __init__(
        self,
        renderer: FilamentRenderer,
        model: mujoco.MjModel,
        scene: Scene,
        lens: Intrinsics,
        times_us: Sequence[int],
        seconds: Callable[[int], float],
        *,
        supersample: int,
        spacing_px: float,
        step_px: float,
    ) -> None:
        """Draw the still street, and plan the keyframes.

        Args:
            renderer: of `model`; its lens is `sim.keyframes.steady_lens`'s.
            model: the scene's, in luminance.
            scene: what moves, and how.
            lens: the camera's.
            times_us: when the samples will be [µs].
            seconds: from a time [µs] to the scene's own [s].
            supersample: fine points per pixel and axis.
            spacing_px: how far an object may move from one keyframe to the next [px].
            step_px: how far anything moves from one sample to the next, at most [px].
        """
        self._renderer, self._model, self._scene = renderer, model, scene
        self._wide, self._lens, self._seconds = renderer.intrinsics, lens, seconds
        self._scale = SHAKE_SCALE if scene.shake else 1
        self._size, self._pose = -(-supersample // self._scale), scene.pose
        self._blur_px = 0.0 if scene.shake else LENS_BLUR_PX
        self._data = mujoco.MjData(model)
        self._place(times_us[0])
        soup = triangle_soup(model)
        moving = [int(b) for o in scene.objects for b in o.bodies]
        self._movers, self._still_soup = soup.of_bodies(moving), soup.without_bodies(moving)
        self._reach = LightReach(model, self._data, scene.objects, self._pose, self._wide)
        self._outlines = Outlines(
            self._movers, parts(model, scene.objects), self._pose, self._wide, self._size
        )
        self._light = MovingLight(model, self._movers, self._reach)
        self._mains = (
            FlickeringLamps(scene.flickering_lights, scene.flickering_materials)
            if scene.flicker
            else None
        )
        self._weights = aperture_weights(self._size, self._blur_px)
        plan, reach = self._plan(
            times_us, spacing_px * self._scale, max(int(PLAN_STEP_PX / step_px), 1)
        )
        self._street = self._draw_street(reach)
        self._keyframes = KeyframeStore(
            plan,
            scene.objects,
            self._keyframe_drawing().draw,
            carriers=self._outlines.parts.body,
            per_pixel=self._size,
        )
        self._still = self._street.pixels.sum(axis=0)
        self._still_visible = look(self._still_soup, body_poses(self._data), self._pose, self._wide)

    def draw(self, t_us: int) -> Drawn:
        """Draw one sample; times may not go back."""
        self._keyframes.advance(t_us)
        self._place(t_us)
        t_s = self._seconds(t_us)
        poses = body_poses(self._data)
        luminance, visible, rectangles = self._at_rest(t_us, poses)
        if self._scene.shake is None:
            return Drawn(luminance, visible, rectangles)
        pose = self._scene.pose_at(t_s)
        luminance = rotated_image(luminance, self._pose, self._wide, pose, self._lens)
        visible = look(self._still_soup, poses, pose, self._lens)
        visible = look(self._movers, poses, pose, self._lens, visible)
        return Drawn(luminance, visible, [(0, 0, self._lens.width, self._lens.height)])

    def _at_rest(self, t_us: int, poses: F64) -> tuple[Luminance, Visible, list[Rectangle]]:
        """What the camera at rest sees, and what of it may differ from the still street."""
        factor = self._scene.flicker_factor(self._seconds(t_us))
        gains = self._gains(factor)
        still = self._still
        if self._mains is not None:
            still = np.tensordot(gains.astype(np.float32), self._street.pixels, axes=1)
        flat, part = self._outlines.project(poses)
        reach = self._reach.at(self._data)
        seen = self._outlines.rectangles(flat, part, self._scene.objects)
        rectangles = merged([w for w in seen if w] + reach.rectangles)
        luminance = still.copy()
        visible = self._still_visible
        if rectangles:
            visible = Visible(visible.body.copy(), visible.nearness.copy())
            lights = self._light.lights(self._data, poses, reach, gains)
            views = compose_transforms(poses, self._pose.into)
            surfaces = self._keyframes.surfaces(t_us, views, factor)
            eye = Eye(self._wide.focal_px, self._wide.width / 2, self._wide.height / 2)
            for rectangle in rectangles:
                label, nearness = self._outlines.points(
                    flat, part, rectangle, self._street.nearness
                )
                compose(
                    luminance,
                    self._street,
                    lights,
                    surfaces,
                    eye,
                    label,
                    nearness,
                    self._weights,
                    rectangle,
                )
                self._show(visible, label, nearness, rectangle)
        if self._mains is not None:
            rectangles = [(0, 0, self._wide.width, self._wide.height)]
        return luminance, visible, rectangles

    def _show(self, visible: Visible, label: I32, nearness: F32, rectangle: Rectangle) -> None:
        middle = slice(self._size // 2, None, self._size)
        body = self._outlines.parts.bodies(label[middle, middle])
        show_middles(visible, body, nearness[middle, middle], rectangle, 1)

    def _place(self, t_us: int) -> None:
        self._scene.place(self._data, self._seconds(t_us))

    def _gains(self, factor: float) -> F64:
        """What each part of the street is multiplied by: steady, lights, mains."""
        gains = np.ones(1 + len(self._reach.shadowing) + (self._mains is not None))
        if self._mains is not None:
            gains[1:-1][np.isin(self._reach.shadowing, self._mains.lights)] = factor
            gains[-1] = factor
        return gains

    def _plan(
        self, times_us: Sequence[int], spacing_px: float, stride: int
    ) -> tuple[dict[str, list[int]], list[Rectangle]]:
        """Times of the keyframes by the object's name, and what shadows and beams reach."""
        times = sorted({*times_us[::stride], times_us[-1]})
        objects = self._scene.objects
        corners_m = np.empty((len(objects), len(times), 8, 3))
        reach: list[Rectangle] = []
        for k, t_us in enumerate(times):
            self._place(t_us)
            corners_m[:, k] = [obj.corners_m(self._data) for obj in objects]
            reach = merged(reach + self._reach.at(self._data).rectangles)
        plan = {}
        for obj, corners in zip(objects, corners_m, strict=True):
            pixels, depth = project(corners.reshape(-1, 3), self._pose, self._wide)
            pixels = np.nan_to_num(pixels.reshape(-1, 8, 2), nan=np.inf)
            plan[obj.name] = keyframe_times(
                times,
                pixels,
                self._in_view(pixels, depth.reshape(-1, 8)),
                spacing_px,
                LIMBS_KEYFRAME_US if obj.has_limbs else None,
            )
        return plan, reach

    def _in_view(self, pixels: F64, depth: F64) -> npt.NDArray[np.bool_]:
        """(n,) whether boxes of (n, 8, 2) corners may be seen, now or within a plan's step."""
        size = np.array([self._wide.width, self._wide.height])
        low, high = pixels.min(axis=1), pixels.max(axis=1)
        margin = 2 * PLAN_STEP_PX
        inside = ((low < size + margin) & (high > -margin)).all(axis=1)
        return np.asarray(inside | (depth <= 0).any(axis=1))

    def _keyframe_drawing(self) -> KeyframeDrawing:
        fine = self._size * (1 if self._scene.shake else KEYFRAME_FINER)
        return KeyframeDrawing(
            self._renderer,
            self._model,
            self._data,
            self._place,
            replace(self._outlines, size=fine),
            self._scene.objects,
            self._mains,
            street_nearness(self._wide, self._data, self._pose, self._still_soup, fine),
            0.0 if self._scene.shake else blur_before_interpolation_px(self._size),
            self._size,
        )

    def _draw_street(self, reach: list[Rectangle]) -> Background:
        """Draw the street without what moves."""
        geoms = [int(g) for o in self._scene.objects for g in o.geoms]
        off = {int(k): 0.0 for k in self._reach.beams}
        spare, held = math.ceil(2 * PLAN_STEP_PX), np.array(hull(reach))
        rectangle = rectangle_around(held[:2] - spare, held[2:] + spare, self._wide)
        with changed_lights(self._model, off), self._renderer.hidden(geoms):
            return render_background(
                self._renderer,
                self._model,
                self._data,
                self._pose,
                self._still_soup,
                self._reach.shadowing,
                self._mains,
                rectangle or (0, 0, 1, 1),
                self._size,
                self._blur_px,
                finer=SHAKE_FINER if self._scene.shake else 1,
                with_albedo=bool(self._reach.beams.size),
            )
