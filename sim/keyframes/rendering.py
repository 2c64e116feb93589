"""How a keyframe is drawn: an object as the renderer sees it, cut into its bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.rectangles import Rectangle
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.keyframes.mover_visibility import Outlines, turning_bodies
from sim.keyframes.store import Keyframe, Piece, cut_pieces
from sim.raster.scan_conversion import NOTHING
from sim.render.filament import FilamentRenderer
from sim.scene.lamp_flicker import FlickeringLamps, changed_lights, sky_lights
from sim.scene.moving_objects import MovingObject
from sim.shadows.shadow_casters import shadow_casting_geoms

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]

LEAST_ALBEDO = 1e-3
"""Grid points that show less of a body, times its albedo, tell nothing of the light on it
(assumed)."""
LEAST_TRACE = 1e-9
"""The same of the mean over a neighbourhood: above what rounding leaves (assumed)."""
SPREAD = 3
"""Where nothing tells of it, the light is that of a neighbourhood so many times as wide, and so on
until something does (assumed)."""


class KeyframeDrawing:
    """Draws keyframes of a scene."""

    def __init__(
        self,
        renderer: FilamentRenderer,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        place: Callable[[int], None],
        outlines: Outlines,
        objects: tuple[MovingObject, ...],
        mains: FlickeringLamps | None,
        street_nearness: F32,
        blur_px: float,
        per_pixel: int,
    ) -> None:
        """Take what is to be drawn.

        Args:
            renderer: of `model`.
            model: its lights are changed, and put back.
            data: poses of the model.
            place: moves `data` to a time [µs].
            outlines: of all that moves, as fine as it is to be drawn.
            objects: likewise.
            mains: what flickers, or nothing.
            street_nearness: at the same fine points, float32 [1/m].
            blur_px: deviation of the lens's point spread [px].
            per_pixel: grid points that are kept per pixel and axis.
        """
        self._renderer, self._model, self._data, self._place = renderer, model, data, place
        self.outlines, self._mains = outlines, mains
        self._street_nearness, self._blur_px = street_nearness, blur_px
        self._per_pixel = per_pixel
        self._sky = sky_lights(model)
        self._moving = np.concatenate([obj.geoms for obj in objects])
        self._still = np.setdiff1d(np.arange(model.ngeom), self._moving)

    def draw(self, obj: MovingObject, t_us: int) -> Keyframe:
        """An object at a time."""
        self._place(t_us)
        poses = body_poses(self._data)
        flat, part = self.outlines.project(poses)
        (rectangle,) = self.outlines.rectangles(flat, part, (obj,))
        if rectangle is None:
            return Keyframe(t_us, {})
        label, lit = self._uncovered(obj, flat, part, rectangle)
        into = compose_transforms(poses, self.outlines.pose.into)
        views = {k: into[self.outlines.parts.body[k]] for k in self.outlines.of(obj)}
        key = Keyframe(t_us, self._cut(lit, label, views, rectangle))
        wheels = turning_bodies(obj) if self._sky.size else []
        turning = [k for k in key.pieces if self.outlines.parts.body[k] in wheels]
        inner = self.outlines.around(self.outlines.span_px(flat, part)[turning])
        if inner is None:
            return key
        box = self._within(inner, rectangle)
        albedo = self._albedo(inner, wheels)
        whole, _ = self._points(flat, part, np.isin(part, turning), inner)
        carried = dict.fromkeys(turning, into[obj.root])
        bright = self._cut(lit[:, *box], label[box], carried, inner)
        dull = self._cut(albedo, label[box], carried, inner)
        own = self._cut(albedo, whole, {k: views[k] for k in turning}, inner)
        own = {k: steadied(piece, len(lit)) for k, piece in own.items()}
        return Keyframe(t_us, key.pieces | own, {k: _glow(bright[k], dull[k]) for k in turning})

    def _within(self, inner: Rectangle, outer: Rectangle) -> tuple[slice, slice]:
        """Rows and columns of a rectangle's fine points in another's."""
        size = self.outlines.size
        x0, y0, x1, y1 = inner
        rows = slice((y0 - outer[1]) * size, (y1 - outer[1]) * size)
        return rows, slice((x0 - outer[0]) * size, (x1 - outer[0]) * size)

    def _uncovered(
        self, obj: MovingObject, flat: F64, part: I32, rectangle: Rectangle
    ) -> tuple[I32, F32]:
        """Labels and light of an object and, where others stand before it, without these.

        Their shadows are then missing there, too.
        """
        label, _ = self.outlines.points(flat, part, rectangle, self._street_nearness)
        lit = self._lit(obj, rectangle)
        mine = self.outlines.of(obj)
        if np.isin(label, [NOTHING, *mine]).all():
            return label, lit
        alone, _ = self._points(flat, part, np.isin(part, mine), rectangle)
        covered = (alone != NOTHING) & (alone != label)
        if covered.any():
            inner = self._around(covered, rectangle)
            box = self._within(inner, rectangle)
            with self._renderer.hidden(self._geoms_but(obj.bodies)):
                bare = self._lit(obj, inner)
            lit[:, *box] = np.where(covered[box], bare, lit[:, *box])
        return alone, lit

    def _around(self, marked: Bools, rectangle: Rectangle) -> Rectangle:
        """The rectangle around marked fine points of another."""
        rows, columns = (k // self.outlines.size for k in np.nonzero(marked))
        x0, y0 = rectangle[:2]
        return (
            x0 + int(columns.min()),
            y0 + int(rows.min()),
            x0 + int(columns.max()) + 1,
            y0 + int(rows.max()) + 1,
        )

    def _points(self, flat: F64, part: I32, which: Bools, rectangle: Rectangle) -> tuple[I32, F32]:
        return self.outlines.points(flat[which], part[which], rectangle, self._street_nearness)

    def _geoms_but(self, bodies: npt.ArrayLike) -> list[int]:
        """All that moves, but for some bodies."""
        geoms = self._moving
        body = self._model.body_weldid[self._model.geom_bodyid[geoms]]
        return [int(g) for g in geoms[~np.isin(body, bodies)]]

    def _cut(
        self, fine: F32, label: I32, views: dict[int, F64], rectangle: Rectangle
    ) -> dict[int, Piece]:
        size, blur_px = self.outlines.size, self._blur_px
        return cut_pieces(
            fine, label, views, rectangle[:2], size, blur_px, per_pixel=self._per_pixel
        )

    def _lit(self, obj: MovingObject, rectangle: Rectangle) -> F32:
        """(parts, rows, columns) luminance: the steady part, and what the mains' lamps add.

        Of what never moves, only that is there which may shade the object.
        """
        shading = shadow_casting_geoms(
            self._model, self._data, self._still, obj.corners_m(self._data)
        )
        with self._renderer.hidden(np.setdiff1d(self._still, shading)):
            fine = self._fine(rectangle)
            if self._mains is None:
                return fine[None]
            with self._mains.scaled(self._model, 0.0):
                steady = self._fine(rectangle)
        return np.stack([steady, fine - steady])

    def _albedo(self, rectangle: Rectangle, bodies: list[int]) -> F32:
        """(1, rows, columns) what bodies return of an even sky's light, nothing before them."""
        lights: dict[int, float] = dict.fromkeys(range(self._model.nlight), 0.0)
        lights |= {int(k): 1.0 for k in self._sky}
        others = [*self._geoms_but(bodies), *self._still]
        with changed_lights(self._model, lights), self._renderer.hidden(others):
            return self._fine(rectangle, shadows=False)[None]

    def _fine(self, rectangle: Rectangle, *, shadows: bool = True) -> F32:
        self._renderer.update(self._data)
        return self._renderer.subpixel_luminance(
            self.outlines.pose, rectangle, self.outlines.size, shadows=shadows
        )


def steadied(piece: Piece, parts: int) -> Piece:
    """A piece that the mains' lamps add nothing to."""
    light = np.zeros((parts, *piece.cover.shape), np.float32)
    light[0] = piece.light[0]
    return replace(piece, light=light)


def _glow(lit: Piece, albedo: Piece) -> Piece:
    """The light on a body, also where the body has gaps."""
    light = np.stack([filled_ratio(part, albedo.light[0]) for part in lit.light])
    return Piece(lit.x0, lit.y0, light, np.ones_like(lit.cover), albedo.view)


def filled_ratio(above: F32, below: F32) -> F32:
    """Quotient where the divisor is large enough; elsewhere that of ever wider neighbourhoods.

    Args:
        above: (rows, columns) float32.
        below: likewise, not negative.

    Returns:
        (rows, columns) float32; 0 everywhere if `below` is.
    """
    out = np.zeros_like(above)
    missing = np.ones(above.shape, np.bool_)
    width, least, most = 1, LEAST_ALBEDO, SPREAD * max(above.shape)
    tops, bottoms = above.astype(np.float64), below.astype(np.float64)
    while missing.any() and width <= most:
        known = missing & (bottoms > least)
        out[known] = tops[known] / bottoms[known]
        missing &= ~known
        width, least = SPREAD * width, LEAST_TRACE
        tops, bottoms = _blurred(above, width), _blurred(below, width)
    return out


def _blurred(image: F32, width: int) -> F64:
    """Mean over a square around each point, in float64: running sums leave no rounding behind."""
    wide = image.astype(np.float64)
    return np.asarray(cv2.blur(wide, (width, width), borderType=cv2.BORDER_CONSTANT), np.float64)
