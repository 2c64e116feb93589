"""Renders keyframes: the luminance of one object at one time, cut into the object's parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.rectangles import Rectangle
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.keyframes.holes import fill_holes
from sim.keyframes.mover_visibility import MoverRaster, wheel_bodies
from sim.keyframes.store import Keyframe, Patch, cut_patches
from sim.raster.scan_conversion import NO_LABEL
from sim.render.filament import FilamentRenderer
from sim.scene.lamp_flicker import FlickeringLamps, changed_lights, sky_lights
from sim.scene.moving_objects import MovingObject
from sim.shadows.beams_that_miss import beams_that_miss
from sim.shadows.shadow_casters import shadow_casting_geoms

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]

MIN_ALBEDO = 1e-3
"""Coverage × albedo below which a grid point does not determine a part's illumination (assumed)."""
MIN_MEAN_ALBEDO = 1e-9
"""The corresponding limit for the mean over a neighbourhood: above rounding errors (assumed)."""
NEIGHBOURHOOD_GROWTH = 3
"""Growth of the neighbourhood whose illumination fills a gap. It is enlarged by this factor until
something in it determines the illumination (assumed)."""


class KeyframeRenderer:
    """Renders keyframes of a scene."""

    def __init__(
        self,
        renderer: FilamentRenderer,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        place: Callable[[int], None],
        raster: MoverRaster,
        objects: tuple[MovingObject, ...],
        flickering: FlickeringLamps | None,
        background_nearness: F32,
        blur_px: float,
        per_pixel: int,
    ) -> None:
        """Create a renderer of keyframes.

        Args:
            renderer: renderer of `model`.
            model: model whose lights are changed temporarily.
            data: poses of the model.
            place: moves `data` to a time [µs].
            raster: rasteriser of all moving objects, at the resolution to render at.
            objects: the moving objects.
            flickering: lamps that flicker; None if there are none.
            background_nearness: nearness of the background at the sub-pixels, float32 [1/m].
            blur_px: standard deviation of the lens's point spread [px].
            per_pixel: grid points that are stored per pixel and axis.
        """
        self._renderer, self._model, self._data, self._place = renderer, model, data, place
        self.raster, self._flickering = raster, flickering
        self._background_nearness, self._blur_px = background_nearness, blur_px
        self._per_pixel = per_pixel
        self._sky = sky_lights(model)
        self._moving = np.concatenate([obj.geoms for obj in objects])
        self._spots = np.flatnonzero(model.light_type == mujoco.mjtLightType.mjLIGHT_SPOT)
        self._static = np.setdiff1d(np.arange(model.ngeom), self._moving)

    def render(self, obj: MovingObject, t_us: int) -> Keyframe:
        """Return an object's keyframe at a time [µs]."""
        self._place(t_us)
        poses = body_poses(self._data)
        projected, part = self.raster.project(poses)
        (rectangle,) = self.raster.rectangles(projected, part, (obj,))
        if rectangle is None:
            return Keyframe(t_us, {})
        label, image = self._unoccluded(obj, projected, part, rectangle)
        body_views = compose_transforms(poses, self.raster.pose.world_to_camera)
        views = {k: body_views[self.raster.parts.body[k]] for k in self.raster.parts_of(obj)}
        key = Keyframe(t_us, self._cut(image, label, views, rectangle))
        wheels = wheel_bodies(obj) if self._sky.size else []
        rotating = [k for k in key.patches if self.raster.parts.body[k] in wheels]
        inner = self.raster.rectangle_of(self.raster.bounds_px(projected, part)[rotating])
        if inner is None:
            return key
        box = self._subpixels_within(inner, rectangle)
        whole, _ = self._rasterise(projected, part, np.isin(part, rotating), inner)
        albedo = self._albedo(inner, wheels)
        fill_holes(albedo, whole)
        on_root = dict.fromkeys(rotating, body_views[obj.root])
        lit = self._cut(image[:, *box], label[box], on_root, inner)
        reflecting = self._cut(albedo, label[box], on_root, inner)
        patches = self._cut(albedo, whole, {k: views[k] for k in rotating}, inner)
        patches = {k: without_flicker(patch, len(image)) for k, patch in patches.items()}
        return Keyframe(
            t_us,
            key.patches | patches,
            {k: _illumination(lit[k], reflecting[k]) for k in rotating},
        )

    def _subpixels_within(self, inner: Rectangle, outer: Rectangle) -> tuple[slice, slice]:
        """Return the rows and columns of a rectangle's sub-pixels in a larger rectangle."""
        size = self.raster.supersample
        x0, y0, x1, y1 = inner
        rows = slice((y0 - outer[1]) * size, (y1 - outer[1]) * size)
        return rows, slice((x0 - outer[0]) * size, (x1 - outer[0]) * size)

    def _unoccluded(
        self, obj: MovingObject, projected: F64, part: I32, rectangle: Rectangle
    ) -> tuple[I32, F32]:
        """Return labels and luminance of an object without the objects in front of it.

        Where other objects are in front of it, their shadows are missing, too.
        """
        label, _ = self.raster.rasterise(projected, part, rectangle, self._background_nearness)
        image = self._luminance(obj, rectangle)
        own = self.raster.parts_of(obj)
        if np.isin(label, [NO_LABEL, *own]).all():
            fill_holes(image, label)
            return label, image
        alone, _ = self._rasterise(projected, part, np.isin(part, own), rectangle)
        occluded = (alone != NO_LABEL) & (alone != label)
        if occluded.any():
            inner = self._rectangle_around(occluded, rectangle)
            box = self._subpixels_within(inner, rectangle)
            with self._renderer.hidden(self._moving_geoms_except(obj.bodies)):
                revealed = self._luminance(obj, inner)
            image[:, *box] = np.where(occluded[box], revealed, image[:, *box])
        fill_holes(image, alone)
        return alone, image

    def _rectangle_around(self, marked: Bools, rectangle: Rectangle) -> Rectangle:
        """Return the rectangle around the marked sub-pixels of another rectangle."""
        rows, columns = (k // self.raster.supersample for k in np.nonzero(marked))
        x0, y0 = rectangle[:2]
        return (
            x0 + int(columns.min()),
            y0 + int(rows.min()),
            x0 + int(columns.max()) + 1,
            y0 + int(rows.max()) + 1,
        )

    def _rasterise(
        self, projected: F64, part: I32, mask: Bools, rectangle: Rectangle
    ) -> tuple[I32, F32]:
        """Rasterise the triangles that a mask selects."""
        return self.raster.rasterise(
            projected[mask], part[mask], rectangle, self._background_nearness
        )

    def _moving_geoms_except(self, bodies: npt.ArrayLike) -> list[int]:
        """Return the geoms of all moving bodies except the given ones."""
        geoms = self._moving
        body = self._model.body_weldid[self._model.geom_bodyid[geoms]]
        return [int(g) for g in geoms[~np.isin(body, bodies)]]

    def _cut(
        self, image: F32, label: I32, views: dict[int, F64], rectangle: Rectangle
    ) -> dict[int, Patch]:
        size, blur_px = self.raster.supersample, self._blur_px
        return cut_patches(
            image, label, views, rectangle[:2], size, blur_px, per_pixel=self._per_pixel
        )

    def _luminance(self, obj: MovingObject, rectangle: Rectangle) -> F32:
        """Return (layers, rows, columns) luminance: the steady layer, and that of flickering lamps.

        Of the static geoms, only those that may shade the object are rendered; of the spot lights,
        only those that may light it are on.
        """
        model, data = self._model, self._data
        casters = shadow_casting_geoms(model, data, self._static, obj.corners_m(data))
        triangles_m = self.raster.movers.of_bodies(obj.bodies).transformed(body_poses(data))
        missing = beams_that_miss(model, data, self._spots, triangles_m)
        with (
            self._renderer.hidden(np.setdiff1d(self._static, casters)),
            changed_lights(model, dict.fromkeys(missing.tolist(), 0.0)),
        ):
            image = self._render_subpixels(rectangle)
            if self._flickering is None:
                return image[None]
            with self._flickering.scaled(self._model, 0.0):
                steady = self._render_subpixels(rectangle)
        return np.stack([steady, image - steady])

    def _albedo(self, rectangle: Rectangle, bodies: list[int]) -> F32:
        """Return the luminance of bodies under an even sky, with all else hidden.

        Returns:
            (1, rows, columns).
        """
        lights: dict[int, float] = dict.fromkeys(range(self._model.nlight), 0.0)
        lights |= {int(k): 1.0 for k in self._sky}
        others = [*self._moving_geoms_except(bodies), *self._static]
        with changed_lights(self._model, lights), self._renderer.hidden(others):
            return self._render_subpixels(rectangle, shadows=False)[None]

    def _render_subpixels(self, rectangle: Rectangle, *, shadows: bool = True) -> F32:
        self._renderer.update(self._data)
        pose, size = self.raster.pose, self.raster.supersample
        return self._renderer.subpixel_luminance(
            pose, rectangle, size, shadows=shadows, skybox=False
        )


def without_flicker(patch: Patch, layers: int) -> Patch:
    """Return a patch with `layers` layers in which the layer of the flickering lamps is 0."""
    luminance = np.zeros((layers, *patch.coverage.shape), np.float32)
    luminance[0] = patch.luminance[0]
    return replace(patch, luminance=luminance)


def _illumination(lit: Patch, albedo: Patch) -> Patch:
    """Return the illumination of a part, with the part's gaps filled."""
    layers = [gap_filled_ratio(layer, albedo.luminance[0]) for layer in lit.luminance]
    return Patch(lit.x0, lit.y0, np.stack(layers), np.ones_like(lit.coverage), albedo.view)


def gap_filled_ratio(numerator: F32, denominator: F32) -> F32:
    """Divide two images; where the denominator is too small, take the ratio of a neighbourhood.

    The neighbourhood of such a point is enlarged until its mean denominator is large enough.

    Args:
        numerator: (rows, columns) float32.
        denominator: (rows, columns) float32, not negative.

    Returns:
        (rows, columns) float32; 0 everywhere if the denominator is 0 everywhere.
    """
    out = np.zeros_like(numerator)
    missing = np.ones(numerator.shape, np.bool_)
    width, minimum, max_width = 1, MIN_ALBEDO, NEIGHBOURHOOD_GROWTH * max(numerator.shape)
    upper, lower = numerator.astype(np.float64), denominator.astype(np.float64)
    while missing.any() and width <= max_width:
        known = missing & (lower > minimum)
        out[known] = upper[known] / lower[known]
        missing &= ~known
        width, minimum = NEIGHBOURHOOD_GROWTH * width, MIN_MEAN_ALBEDO
        upper, lower = _blurred(numerator, width), _blurred(denominator, width)
    return out


def _blurred(image: F32, width: int) -> F64:
    """Return the mean over a square around each point.

    The mean is computed in float64, in which running sums leave no rounding errors behind.
    """
    image64 = image.astype(np.float64)
    return np.asarray(cv2.blur(image64, (width, width), borderType=cv2.BORDER_CONSTANT), np.float64)
