"""Colour preview images of a crossing, rendered separately from the photometric samples."""

from __future__ import annotations

import copy
import hashlib
import math
import struct
from collections.abc import Iterable, Iterator, Sequence

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from sim.cache.key import luminance_key
from sim.crossing import Crossing
from sim.geometry.rectangles import (
    Rectangle,
    enclosing_rectangle,
    image_rectangle,
    rectangle_of_points,
)
from sim.render.filament import FilamentRenderer
from sim.scene.facade_style import LIT_WINDOW
from sim.scene.lighting import SKY_TEXTURE
from sim.scene.scene import Scene
from sim.shadows.shadows_and_beams import AffectedAreaFinder

Image = npt.NDArray[np.uint8]

PREVIEW_LUX = 60_000.0
"""Illuminance for which the preview is exposed [lux] (chosen by eye)."""
PREVIEW_SKY_RGB = (170, 205, 255)
"""Colour of the sky in the preview, sRGB (chosen by eye)."""
PREVIEW_SCALE = 1.5
"""Preview pixels per sensor pixel and axis. This gives 519×390, about a quarter of a wide screen
(assumed)."""
JPEG_QUALITY = 85
"""JPEG quality of the preview, 0 to 100 (chosen by eye)."""
_LENGTH = struct.Struct("<I")


class Preview:
    """Renders a crossing in colour, exposed for its illuminance. Use as a context manager.

    After the first image, only the area is rendered in which something has moved.
    """

    def __init__(self, crossing: Crossing) -> None:
        """Set up a separate renderer for the colour model.

        Args:
            crossing: crossing to show.

        Raises:
            RendererError: this machine cannot render.
        """
        self._crossing, self._scene = crossing, crossing.scene
        model = preview_model(crossing.scene)
        self._data = mujoco.MjData(model)
        self._scene.place(self._data, 0.0)
        self._areas = AffectedAreaFinder(
            model, self._data, self._scene.objects, self._scene.pose, crossing.intrinsics
        )
        self._renderer = FilamentRenderer(model, crossing.intrinsics)
        self._image: Image = np.empty((0, 0, 3), np.uint8)
        self._moving: list[Rectangle] = []

    def __enter__(self) -> Preview:
        return self

    def __exit__(self, *_: object) -> None:
        self._renderer.close()

    def render(self, t_us: int, *, scale: float = PREVIEW_SCALE) -> Image:
        """Render the street at one time.

        Args:
            t_us: time since the start of the sequence [µs].
            scale: preview pixels per sensor pixel and axis.

        Returns:
            (height·scale, width·scale, 3) uint8 sRGB.
        """
        t_s, lens = self._crossing.seconds(t_us), self._crossing.intrinsics
        self._scene.place(self._data, t_s)
        height, width = round(lens.height * scale), round(lens.width * scale)
        moving, image = self._moving_areas(), self._image
        changed = enclosing_rectangle(self._moving + moving)
        if self._scene.shake or image.shape[:2] != (height, width):
            image, changed = np.empty((height, width, 3), np.uint8), image_rectangle(lens)
        x0, y0 = (math.floor(edge * scale) for edge in changed[:2])
        x1, y1 = (
            min(math.ceil(changed[2] * scale), width),
            min(math.ceil(changed[3] * scale), height),
        )
        if x0 < x1:
            self._renderer.update(self._data)
            pose = self._scene.pose_at(t_s)
            image[y0:y1, x0:x1] = self._renderer.preview(pose, (x0, y0, x1, y1), scale)
        self._image, self._moving = image, moving
        return image.copy()

    def _moving_areas(self) -> list[Rectangle]:
        """Return the rectangles of the moving objects, their shadows and beams."""
        scene, lens = self._scene, self._crossing.intrinsics
        corners = (obj.corners_m(self._data) for obj in scene.objects)
        seen = (rectangle_of_points(points, scene.pose, lens) for points in corners)
        return [area for area in seen if area] + self._areas.find(self._data).rectangles


def preview_model(scene: Scene) -> mujoco.MjModel:
    """Return the scene's model in colour, with its lights scaled to the preview's exposure."""
    model = copy.copy(scene.model)
    gain = PREVIEW_LUX / scene.config.illuminance
    model.light_intensity[:] *= gain
    model.mat_emission[:] *= gain**0.25  # by eye: at full gain lamps turn white
    windows = [k for k in range(model.nmat) if model.mat(k).name.startswith(LIT_WINDOW)]
    model.mat_emission[windows] *= gain**0.6
    sky = int(model.tex_adr[model.texture(SKY_TEXTURE).id])
    model.tex_data[sky:].reshape(-1, 3)[:] = PREVIEW_SKY_RGB
    return model


def preview_jpegs(crossing: Crossing, times_us: Sequence[int]) -> list[bytes]:
    """Return a colour image at each time as JPEG, from the crossing's cache if it has one.

    Args:
        crossing: crossing to show.
        times_us: times in any order [µs].

    Raises:
        RendererError: the images are not in the cache, and this machine cannot render.
    """

    def rendered() -> bytes:
        return _joined(_rendered(crossing, times_us))

    if crossing.cache is None:
        return list(_rendered(crossing, times_us))
    of_luminance = luminance_key(
        crossing.config, crossing.scene.model, crossing.intrinsics, times_us
    )
    key = hashlib.sha256(f"previews of {of_luminance}".encode()).hexdigest()
    return _split(crossing.cache.get_or_make(key, rendered))


def _rendered(crossing: Crossing, times_us: Sequence[int]) -> Iterator[bytes]:
    with Preview(crossing) as preview:
        for t_us in times_us:
            bgr = cv2.cvtColor(preview.render(t_us), cv2.COLOR_RGB2BGR)
            yield cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()


def _joined(parts: Iterable[bytes]) -> bytes:
    """Join byte strings into one, each preceded by its length."""
    return b"".join(_LENGTH.pack(len(part)) + part for part in parts)


def _split(joined: bytes) -> list[bytes]:
    """Undo `_joined`."""
    parts, at = [], 0
    while at < len(joined):
        start = at + _LENGTH.size
        at = start + _LENGTH.unpack_from(joined, at)[0]
        parts.append(joined[start:at])
    return parts
