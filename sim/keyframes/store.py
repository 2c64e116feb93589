"""Keyframes: surfaces as rendered at a few times, stored part by part and moved to other times.

An object gets a keyframe whenever it has moved by a set distance in the image. In between, its
surfaces are interpolated between the keyframes before and after. A wheel rotates far in that time,
while its illumination stays in place. Its albedo is therefore looked up in the wheel's frame, and
its illumination in the vehicle's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from sim.geometry.rigid_transform import compose_transforms, inverse_transform
from sim.keyframes.surface_lookup import Surfaces
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
        render: Callable[[MovingObject, int], Keyframe],
        *,
        carriers: I32,
        per_pixel: int,
    ) -> None:
        """Start without keyframes.

        Args:
            plan: times of the keyframes [µs], by object name; see `sim.keyframes.plan`.
            objects: the moving objects.
            render: renders an object's keyframe at a time [µs].
            carriers: (parts,) number of the body that each part moves with.
            per_pixel: grid points of a patch per pixel and axis.
        """
        self._plan, self._objects, self._render = plan, objects, render
        self._carriers, self._per_pixel = carriers, per_pixel
        self._keys: dict[str, list[Keyframe]] = {o.name: [] for o in objects}
        self._packed: Surfaces | None = None
        self._flickering: F32 | None = None
        self._steady: F32 | None = None

    def advance(self, t_us: int) -> None:
        """Render the keyframes before and after a time; times must not decrease."""
        for obj in self._objects:
            plan, keys = self._plan[obj.name], self._keys[obj.name]
            before = max(int(np.searchsorted(plan, t_us, side="right")) - 1, 0)
            wanted = plan[before : before + 2]
            if wanted == [key.t_us for key in keys]:
                continue
            have = {key.t_us: key for key in keys}
            self._keys[obj.name] = [have.get(t) or self._render(obj, t) for t in wanted]
            self._packed = None

    def surfaces(self, t_us: int, views: F64, flicker: float) -> Surfaces:
        """Return the surfaces of all parts for the lookup at a time.

        Args:
            t_us: time that the store was advanced to [µs].
            views: (bodies, 3, 4) transform from each body's frame to the camera's at that time.
            flicker: relative flux of the flickering lamps at that time.
        """
        if self._packed is None:
            self._packed = self._pack()
        packed = self._packed
        if self._flickering is not None and self._steady is not None:
            np.multiply(self._flickering, np.float32(flicker), out=packed.luminance)
            np.add(packed.luminance, self._steady, out=packed.luminance)
        for obj in self._objects:
            keys = self._keys[obj.name]
            weights = _weights([key.t_us for key in keys], t_us)
            for k, (key, weight) in enumerate(zip(keys, weights, strict=True)):
                for row, body, patch in self._rows(key, obj.root):
                    packed.weights[row, k] = weight
                    packed.transforms[2 * row + k] = compose_transforms(
                        inverse_transform(views[body]), patch.view
                    )
        return packed

    def _rows(self, key: Keyframe, root: int) -> Iterator[tuple[int, int, Patch]]:
        """Yield the row in `Surfaces`, the number of the body that carries it, and the patch."""
        for part, patch in key.patches.items():
            yield part, int(self._carriers[part]), patch
        for part, patch in key.illumination.items():
            yield len(self._carriers) + part, root, patch

    def _pack(self) -> Surfaces:
        """Concatenate all patches."""
        luminances: list[F32] = []
        coverages = [np.empty(0, np.float32)]
        count = 2 * len(self._carriers)
        patches, means = np.zeros((count, 2, 5), np.int64), np.zeros(count)
        start = 0
        for obj in self._objects:
            for k, key in enumerate(self._keys[obj.name]):
                for row, _, patch in self._rows(key, obj.root):
                    rows, columns = patch.coverage.shape
                    patches[row, k] = start, patch.x0, patch.y0, columns, rows
                    luminances.append(patch.luminance.reshape(len(patch.luminance), -1))
                    coverages.append(patch.coverage.ravel())
                    means[row] = patch.luminance.sum() / patch.coverage.sum()
                    start += patch.coverage.size
        layers = np.concatenate(luminances, axis=1) if luminances else np.empty((1, 0), np.float32)
        self._steady, self._flickering = layers if len(layers) == 2 else (None, None)
        return Surfaces(
            luminance=layers[0].copy(),
            coverage=np.concatenate(coverages),
            patches=patches,
            transforms=np.zeros((2 * count, 3, 4)),
            weights=np.zeros((count, 2)),
            means=means,
            per_pixel=self._per_pixel,
        )


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
        rows, columns = np.nonzero(label == part)
        if not rows.size:
            continue
        first = np.array([rows.min(), columns.min()]) // supersample - 1
        last = np.array([rows.max(), columns.max()]) // supersample + 2
        first = np.maximum(first, 0) * supersample
        last = np.minimum(last * supersample, label.shape)
        box = slice(first[0], last[0]), slice(first[1], last[1])
        mask = (label[box] == part).astype(np.float32)
        patches[part] = Patch(
            x0=corner_px[0] * per_pixel + int(first[1]) // stride,
            y0=corner_px[1] * per_pixel + int(first[0]) // stride,
            luminance=np.stack([through_aperture(mask * layer[box]) for layer in image]),
            coverage=through_aperture(mask),
            view=view,
        )
    return patches


def _weights(keys_us: Sequence[int], t_us: int) -> tuple[float, ...]:
    if len(keys_us) < 2:
        return (1.0,) * len(keys_us)
    first, last = keys_us
    late = min(max((t_us - first) / (last - first), 0.0), 1.0)
    return 1 - late, late
