"""A colour picture of a crossing for the eye, drawn beside the photometric samples."""

from __future__ import annotations

import copy
import hashlib
import struct
from collections.abc import Iterable, Iterator, Sequence

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from sim.cache.key import luminance_key
from sim.crossing import Crossing
from sim.render.filament import FilamentRenderer
from sim.scene.facade_style import LIT_WINDOW
from sim.scene.lighting import SKY_TEXTURE
from sim.scene.scene import Scene

PREVIEW_LUX = 60_000.0
"""What the preview's eye is adapted to (by eye)."""
PREVIEW_SKY_RGB = (170, 205, 255)
"""Of a sky that the picture shows blue (by eye)."""
PREVIEW_SCALE = 1.5
"""Points per sensor pixel and axis: 519×390, about what a quarter of a wide screen shows
(assumed)."""
JPEG_QUALITY = 85
"""Of a picture that is for the eye only (by eye)."""
_LENGTH = struct.Struct("<I")


class Preview:
    """Draws a crossing in colour, exposed for its light; use as a context manager."""

    def __init__(self, crossing: Crossing) -> None:
        """Set up a second renderer.

        Raises:
            RendererError: this machine cannot render.
        """
        self._crossing = crossing
        model = preview_model(crossing.scene)
        self._data = mujoco.MjData(model)
        self._renderer = FilamentRenderer(model, crossing.intrinsics)

    def __enter__(self) -> Preview:
        return self

    def __exit__(self, *_: object) -> None:
        self._renderer.close()

    def draw(self, t_us: int, *, scale: float = PREVIEW_SCALE) -> npt.NDArray[np.uint8]:
        """The street at a time [µs]: (height·scale, width·scale, 3) uint8 sRGB."""
        scene, t_s = self._crossing.scene, self._crossing.seconds(t_us)
        scene.place(self._data, t_s)
        self._renderer.update(self._data)
        return self._renderer.preview(scene.pose_at(t_s), scale=scale)


def preview_model(scene: Scene) -> mujoco.MjModel:
    """The scene in colour, its light scaled to what a picture for the eye is exposed for."""
    model = copy.copy(scene.model)
    gain = PREVIEW_LUX / scene.config.illuminance
    model.light_intensity[:] *= gain
    model.mat_emission[:] *= gain**0.25  # by eye: lamps in full would lose their hue
    windows = [k for k in range(model.nmat) if model.mat(k).name.startswith(LIT_WINDOW)]
    model.mat_emission[windows] *= gain**0.6
    sky = int(model.tex_adr[model.texture(SKY_TEXTURE).id])
    model.tex_data[sky:].reshape(-1, 3)[:] = PREVIEW_SKY_RGB
    return model


def preview_jpegs(crossing: Crossing, times_us: Sequence[int]) -> list[bytes]:
    """A colour picture at each time, as JPEG; kept in the crossing's cache where it has one.

    Args:
        crossing: what to show.
        times_us: when, in any order [µs].

    Raises:
        RendererError: this machine cannot render, and they are not kept.
    """

    def draw() -> bytes:
        return _joined(_drawn(crossing, times_us))

    if crossing.cache is None:
        return list(_drawn(crossing, times_us))
    light = luminance_key(crossing.config, crossing.scene.model, crossing.intrinsics, times_us)
    key = hashlib.sha256(f"previews of {light}".encode()).hexdigest()
    return _parted(crossing.cache.get_or_make(key, draw))


def _drawn(crossing: Crossing, times_us: Sequence[int]) -> Iterator[bytes]:
    with Preview(crossing) as preview:
        for t_us in times_us:
            bgr = cv2.cvtColor(preview.draw(t_us), cv2.COLOR_RGB2BGR)
            yield cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()


def _joined(parts: Iterable[bytes]) -> bytes:
    """Each after its length."""
    return b"".join(_LENGTH.pack(len(part)) + part for part in parts)


def _parted(joined: bytes) -> list[bytes]:
    """What `_joined` joined."""
    parts, at = [], 0
    while at < len(joined):
        start = at + _LENGTH.size
        at = start + _LENGTH.unpack_from(joined, at)[0]
        parts.append(joined[start:at])
    return parts
