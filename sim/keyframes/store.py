"""Keyframes: how surfaces look at few times, kept body by body to be moved to all others.

An object gets a keyframe each time it has moved a set distance in the image. In between, its
surfaces are looked up in the keyframes before and after, each with its share. A wheel turns far in
that time, while the light on it stays: so its albedo is looked up where the wheel was, the light
where the place on the vehicle was.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from sim.geometry.rigid_transform import compose_transforms, inverse_transform
from sim.keyframes.surface_lookup import Surfaces
from sim.raster.aperture import on_grid
from sim.scene.moving_objects import MovingObject

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Piece:
    """One part of an object at a keyframe: a body, or a lamp on it.

    Attributes:
        x0: column of the first grid point.
        y0: row likewise.
        light: (parts, rows, columns) float32, share of the pixel around a grid point that shows
            the body, times its luminance [cd/m²]: the steady part, and what the mains' lamps add.
            Of a body that turns in its light, the albedo instead of the luminance, and no second
            part; of the light on it, luminance over albedo.
        cover: (rows, columns) float32, that share; 1 of the light.
        view: (3, 4) from the body's frame to the camera's.
    """

    x0: int
    y0: int
    light: F32
    cover: F32
    view: F64


@dataclass(frozen=True, eq=False)
class Keyframe:
    """An object at one time.

    Attributes:
        t_us: when [µs].
        pieces: by the part's number; those that are seen.
        glows: by the part's number, the light on those that turn in it; views are the root's.
    """

    t_us: int
    pieces: dict[int, Piece]
    glows: dict[int, Piece] = field(default_factory=dict)


class KeyframeStore:
    """The keyframes around the present time, of every object."""

    def __init__(
        self,
        plan: dict[str, list[int]],
        objects: tuple[MovingObject, ...],
        draw: Callable[[MovingObject, int], Keyframe],
        *,
        carriers: I32,
        per_pixel: int,
    ) -> None:
        """Start empty.

        Args:
            plan: times of the keyframes [µs] by the object's name; see `keyframe_times`.
            objects: what moves.
            draw: makes an object's keyframe at a time.
            carriers: (parts,) number of the body that each part moves with.
            per_pixel: grid points that pieces have per pixel and axis.
        """
        self._plan, self._objects, self._draw = plan, objects, draw
        self._carriers, self._per_pixel = carriers, per_pixel
        self._keys: dict[str, list[Keyframe]] = {o.name: [] for o in objects}
        self._packed: Surfaces | None = None
        self._mains: F32 | None = None
        self._steady: F32 | None = None

    def advance(self, t_us: int) -> None:
        """Have the keyframes before and after a time; times may not go back."""
        for obj in self._objects:
            plan, keys = self._plan[obj.name], self._keys[obj.name]
            before = max(int(np.searchsorted(plan, t_us, side="right")) - 1, 0)
            wanted = plan[before : before + 2]
            if wanted == [key.t_us for key in keys]:
                continue
            have = {key.t_us: key for key in keys}
            self._keys[obj.name] = [have.get(t) or self._draw(obj, t) for t in wanted]
            self._packed = None

    def surfaces(self, t_us: int, views: F64, mains: float) -> Surfaces:
        """The surfaces as the keyframes show them.

        Args:
            t_us: the time advanced to.
            views: (bodies, 3, 4) from each body's frame to the camera's, at that time.
            mains: relative flux of the lamps on the mains.
        """
        if self._packed is None:
            self._packed = self._pack()
        packed = self._packed
        if self._mains is not None and self._steady is not None:
            np.multiply(self._mains, np.float32(mains), out=packed.light)
            np.add(packed.light, self._steady, out=packed.light)
        for obj in self._objects:
            keys = self._keys[obj.name]
            shares = _shares([key.t_us for key in keys], t_us)
            for k, (key, share) in enumerate(zip(keys, shares, strict=True)):
                for row, body, piece in self._rows(key, obj.root):
                    packed.shares[row, k] = share
                    packed.moves[2 * row + k] = compose_transforms(
                        inverse_transform(views[body]), piece.view
                    )
        return packed

    def _rows(self, key: Keyframe, root: int) -> Iterator[tuple[int, int, Piece]]:
        """Row in `Surfaces`, number of the body that carries it, and piece."""
        for part, piece in key.pieces.items():
            yield part, int(self._carriers[part]), piece
        for part, piece in key.glows.items():
            yield len(self._carriers) + part, root, piece

    def _pack(self) -> Surfaces:
        """Lay all pieces end to end."""
        lights: list[F32] = []
        covers = [np.empty(0, np.float32)]
        count = 2 * len(self._carriers)
        pieces, means = np.zeros((count, 2, 5), np.int64), np.zeros(count)
        start = 0
        for obj in self._objects:
            for k, key in enumerate(self._keys[obj.name]):
                for row, _, piece in self._rows(key, obj.root):
                    rows, columns = piece.cover.shape
                    pieces[row, k] = start, piece.x0, piece.y0, columns, rows
                    lights.append(piece.light.reshape(len(piece.light), -1))
                    covers.append(piece.cover.ravel())
                    means[row] = piece.light.sum() / piece.cover.sum()
                    start += piece.cover.size
        parts = np.concatenate(lights, axis=1) if lights else np.empty((1, 0), np.float32)
        self._steady, self._mains = (parts[0], parts[1]) if len(parts) == 2 else (None, None)
        return Surfaces(
            light=parts[0].copy(),
            cover=np.concatenate(covers),
            pieces=pieces,
            moves=np.zeros((2 * count, 3, 4)),
            shares=np.zeros((count, 2)),
            means=means,
            per_pixel=self._per_pixel,
        )


def keyframe_times(
    times_us: Sequence[int],
    corners_px: F64,
    in_view: npt.NDArray[np.bool_],
    spacing_px: float,
    longest_us: int | None = None,
) -> list[int]:
    """When an object gets its keyframes: from when it is first in view to when it is last.

    Args:
        times_us: (n,) times to choose from.
        corners_px: (n, 8, 2) where the corners of its box are in the image.
        in_view: (n,) whether it is.
        spacing_px: how far a corner may move from one keyframe to the next [px].
        longest_us: how long the next keyframe may be off [µs]; None for any time.
    """
    seen = np.flatnonzero(in_view)
    if not seen.size:
        return []
    chosen = [int(seen[0])]
    for k in range(int(seen[0]) + 1, int(seen[-1]) + 1):
        late = longest_us is not None and times_us[k] - times_us[chosen[-1]] >= longest_us
        if late or np.abs(corners_px[k] - corners_px[chosen[-1]]).max() >= spacing_px:
            chosen.append(k)
    if chosen[-1] != seen[-1]:
        chosen.append(int(seen[-1]))
    return [times_us[k] for k in chosen]


def cut_pieces(
    fine: F32,
    label: I32,
    views: dict[int, F64],
    corner_px: tuple[int, int],
    supersample: int,
    blur_px: float,
    *,
    per_pixel: int,
) -> dict[int, Piece]:
    """Cut a drawn rectangle into bodies, each seen through the pixels' aperture.

    Args:
        fine: (parts, rows, columns) float32 of fine points [cd/m²].
        label: (rows, columns) which body each shows.
        views: by the body's number, from its frame to the camera's.
        corner_px: column and row of the rectangle's first pixel.
        supersample: fine points per pixel and axis.
        blur_px: deviation of the lens's point spread [px].
        per_pixel: grid points that are kept per pixel and axis; it divides `supersample`.
    """

    def through_aperture(points: F32) -> F32:
        return on_grid(points, supersample, per_pixel=per_pixel, blur_px=blur_px)

    stride, pieces = supersample // per_pixel, {}
    for body, view in views.items():
        rows, columns = np.nonzero(label == body)
        if not rows.size:
            continue
        first = np.array([rows.min(), columns.min()]) // supersample - 1
        last = np.array([rows.max(), columns.max()]) // supersample + 2
        first = np.maximum(first, 0) * supersample
        last = np.minimum(last * supersample, label.shape)
        box = slice(first[0], last[0]), slice(first[1], last[1])
        mask = (label[box] == body).astype(np.float32)
        pieces[body] = Piece(
            x0=corner_px[0] * per_pixel + int(first[1]) // stride,
            y0=corner_px[1] * per_pixel + int(first[0]) // stride,
            light=np.stack([through_aperture(mask * part[box]) for part in fine]),
            cover=through_aperture(mask),
            view=view,
        )
    return pieces


def _shares(keys_us: Sequence[int], t_us: int) -> tuple[float, ...]:
    if len(keys_us) < 2:
        return (1.0,) * len(keys_us)
    first, last = keys_us
    late = min(max((t_us - first) / (last - first), 0.0), 1.0)
    return 1 - late, late
