"""Keyframes: surfaces as rendered at a few times, stored part by part and moved to other times.

An object gets a keyframe whenever it has moved by a set distance in the image. In between, its
surfaces are interpolated between the keyframes before and after. A wheel rotates far in that time,
while its illumination stays in place. Its albedo is therefore looked up in the wheel's frame, and
its illumination in the vehicle's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from sim.compositing.surface_lookup import Surfaces, move_surfaces
from sim.geometry.pinhole import Projection
from sim.raster.aperture import to_grid
from sim.scene.moving_objects import MovingObject

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Patch:
    """Image of one part of an object at a keyframe.

    Attributes:
        x0: column of the first grid point.
        y0: row of the first grid point.
        luminance: (layers, rows, columns) float32, coverage × luminance [cd/m²]: the steady layer,
            and the layer of the flickering lamps. For a part that rotates relative to the light it
            is coverage × albedo, without a flickering layer. For an illumination it is luminance
            over albedo.
        coverage: (rows, columns) float32, share of the pixel around a grid point that shows the
            part; 1 for an illumination.
        view: (3, 4) transform from the body's frame to the camera's.
    """

    x0: int
    y0: int
    luminance: F32
    coverage: F32
    view: F64


@dataclass(frozen=True, eq=False)
class Keyframe:
    """An object at one time.

    Attributes:
        t_us: time of the keyframe [µs].
        patches: visible parts, by part number.
        illumination: illumination of the parts that rotate relative to the light, by part number;
            the view is that of the object's root body.
    """

    t_us: int
    patches: dict[int, Patch]
    illumination: dict[int, Patch] = field(default_factory=dict)


class KeyframeStore:
    """The keyframes of every object before and after the present time."""

    def __init__(
        self,
        plan: dict[str, list[int]],
        objects: tuple[MovingObject, ...],
        request: Callable[[MovingObject, int], Future[Keyframe]],
        *,
        carriers: I32,
        per_pixel: int,
    ) -> None:
        """Start without keyframes.

        Args:
            plan: times of the keyframes [µs], by object name; see `sim.keyframes.plan`.
            objects: the moving objects.
            request: asks for an object's keyframe at a time [µs]; called in the order of the plan,
                for one keyframe more than is needed.
            carriers: (parts,) number of the body that each part moves with.
            per_pixel: grid points of a patch per pixel and axis.
        """
        self._plan, self._objects, self._request = plan, objects, request
        self._carriers, self._per_pixel = carriers, per_pixel
        self._keys: dict[str, list[Keyframe]] = {o.name: [] for o in objects}
        self._requested: dict[tuple[str, int], Future[Keyframe]] = {}
        self._packed: Surfaces | None = None
        self._flickering: F32 | None = None
        self._steady: F32 | None = None

    def advance(self, t_us: int) -> None:
        """Wait for the keyframes before and after a time, and request those after them.

        Times must not decrease.
        """
        for obj in self._objects:
            plan, keys = self._plan[obj.name], self._keys[obj.name]
            before = max(int(np.searchsorted(plan, t_us, side="right")) - 1, 0)
            wanted = plan[before : before + 2]
            if wanted == [key.t_us for key in keys]:
                continue
            have = {key.t_us: key for key in keys}
            for key_us in plan[before : before + 3]:
                if key_us not in have and (obj.name, key_us) not in self._requested:
                    self._requested[obj.name, key_us] = self._request(obj, key_us)
            self._keys[obj.name] = [
                have.get(key_us) or self._requested.pop((obj.name, key_us)).result()
                for key_us in wanted
            ]
            self._packed = None

    def surfaces(self, t_us: int, views: F64, flicker: float, projection: Projection) -> Surfaces:
        """Return the surfaces of all parts for the lookup at a time.

        Args:
            t_us: time that the store was advanced to [µs].
            views: (bodies, 3, 4) transform from each body's frame to the camera's at that time.
            flicker: relative flux of the flickering lamps at that time.
            projection: projection of the camera.
        """
        if self._packed is None:
            self._packed = self._pack()
        packed = self._packed
        if self._flickering is not None and self._steady is not None:
            packed.grid[:, 0] = self._steady + np.float32(flicker) * self._flickering
        move_surfaces(packed, t_us, views, projection)
        return packed

    def _rows(self, key: Keyframe, root: int) -> Iterator[tuple[int, int, Patch]]:
        """Yield the row in `Surfaces`, the number of the body that carries it, and the patch."""
        for part, patch in key.patches.items():
            yield part, int(self._carriers[part]), patch
        for part, patch in key.illumination.items():
            yield len(self._carriers) + part, root, patch

    def _pack(self) -> Surfaces:
        """Concatenate all patches."""
        count = 2 * len(self._carriers)
        packed = Surfaces(
            grid=np.empty((0, 2), np.float32),
            patches=np.zeros((count, 2, 5), np.int64),
            views=np.zeros((count, 2, 3, 4)),
            carriers=np.zeros(count, np.int32),
            key_us=np.zeros((count, 2), np.int64),
            means=np.zeros(count),
            per_pixel=self._per_pixel,
            matrices=np.zeros((count, 2, 3, 4)),
            weights=np.zeros((count, 2)),
        )
        patches, start = [], 0
        for obj in self._objects:
            keys = self._keys[obj.name]
            for k, key in enumerate(keys):
                for row, body, patch in self._rows(key, obj.root):
                    rows, columns = patch.coverage.shape
                    packed.patches[row, k] = start, patch.x0, patch.y0, columns, rows
                    packed.views[row, k], packed.carriers[row] = patch.view, body
                    packed.key_us[row] = keys[0].t_us, keys[-1].t_us
                    packed.means[row] = patch.luminance.sum() / patch.coverage.sum()
                    patches.append(patch)
                    start += patch.coverage.size
        grid, start = np.empty((start, 2), np.float32), 0
        layers = len(patches[0].luminance) if patches else 1
        luminance = np.empty((layers, len(grid)), np.float32)
        for patch in patches:
            here = slice(start, start + patch.coverage.size)
            luminance[:, here] = patch.luminance.reshape(layers, -1)
            grid[here, 1] = patch.coverage.ravel()
            start = here.stop
        grid[:, 0] = luminance[0]
        self._steady, self._flickering = luminance if layers == 2 else (None, None)
        return packed._replace(grid=grid)


def cut_patches(
    image: F32,
    label: I32,
    views: dict[int, F64],
    corner_px: tuple[int, int],
    supersample: int,
    blur_px: float,
    *,
    per_pixel: int,
) -> dict[int, Patch]:
    """Cut a rendered rectangle into one patch per part, each seen through the pixels' aperture.

    Args:
        image: (layers, rows, columns) float32 luminance of the sub-pixels [cd/m²].
        label: (rows, columns) part that each sub-pixel shows.
        views: transform from the part's frame to the camera's, by part number.
        corner_px: column and row of the rectangle's first pixel.
        supersample: sub-pixels per pixel and axis.
        blur_px: standard deviation of the lens's point spread [px].
        per_pixel: grid points of a patch per pixel and axis; a divisor of `supersample`.
    """

    def through_aperture(subpixels: F32) -> F32:
        return to_grid(subpixels, supersample, per_pixel=per_pixel, blur_px=blur_px)

    stride, patches = supersample // per_pixel, {}
    for part, view in views.items():
        shown = label == part
        rows, columns = (np.flatnonzero(shown.any(axis=axis)) for axis in (1, 0))
        if not rows.size:
            continue
        first = np.array([rows[0], columns[0]]) // supersample - 1
        last = np.array([rows[-1], columns[-1]]) // supersample + 2
        first = np.maximum(first, 0) * supersample
        last = np.minimum(last * supersample, label.shape)
        box = slice(first[0], last[0]), slice(first[1], last[1])
        mask = shown[box].astype(np.float32)
        patches[part] = Patch(
            x0=corner_px[0] * per_pixel + int(first[1]) // stride,
            y0=corner_px[1] * per_pixel + int(first[0]) // stride,
            luminance=np.stack([through_aperture(mask * layer[box]) for layer in image]),
            coverage=through_aperture(mask),
            view=view,
        )
    return patches
