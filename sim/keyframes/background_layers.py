"""The light on the static background, split into layers, so that it is rendered only once.

Light is additive: the luminance that the camera sees is the sum of the contributions of all lights.
The background is therefore rendered once with all lights, once without the lights that cast
shadows, and once with each of these lights alone. A shadow of a moving object then dims the layer
of its own light only. The layer that remains without these lights is rendered by itself: as a
difference of two images it would contain the renderer's rounding errors.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from typing import NamedTuple

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rectangles import Rectangle
from sim.render.filament import FilamentRenderer
from sim.scene.lamp_flicker import FlickeringLamps, changed_lights, sky_lights

F32 = npt.NDArray[np.float32]
Numbers = npt.NDArray[np.int64]


class BackgroundLight(NamedTuple):
    """What the renderer contributes to the background: the luminance and albedo of its sub-pixels.

    Attributes:
        subpixels: as in `sim.compositing.background.Background`.
        subpixel_albedo: as in `sim.compositing.background.Background`.
    """

    subpixels: F32
    subpixel_albedo: F32

    def to_bytes(self) -> bytes:
        """Return both arrays in NumPy's file format."""
        file = io.BytesIO()
        np.save(file, self.subpixels)
        np.save(file, self.subpixel_albedo)
        return file.getvalue()

    @staticmethod
    def from_bytes(content: bytes) -> BackgroundLight:
        """Return what `to_bytes` was called on."""
        file = io.BytesIO(content)
        return BackgroundLight(np.load(file), np.load(file))


def render_light(
    renderer: FilamentRenderer,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    pose: Pose,
    shadow_lights: Numbers,
    flickering: FlickeringLamps | None,
    rectangle: Rectangle,
    supersample: int,
    oversample: int = 1,
    *,
    with_albedo: bool = True,
) -> BackgroundLight:
    """Render the static background, layer by layer.

    Args:
        renderer: renderer of `model`, with moving objects hidden and their lamps off.
        model: model whose lights are changed temporarily.
        data: poses of the static objects.
        pose: pose of the camera.
        shadow_lights: (n,) numbers of the lights that moving objects can block.
        flickering: lamps that flicker; their light becomes the last layer.
        rectangle: area that shadows and beams can reach. Outside it the lights are not separated.
        supersample: sub-pixels per pixel and axis.
        oversample: rendered samples per sub-pixel and axis, which are averaged.
        with_albedo: True if moving objects have lamps. Otherwise the albedo is not needed and
            stays 0.
    """
    lens = renderer.intrinsics

    def render(area: Rectangle) -> F32:
        renderer.update(data)
        return _averaged(
            renderer.subpixel_luminance(pose, area, oversample * supersample), oversample
        )

    layers = _render_layers(render, model, shadow_lights, flickering, rectangle, lens, supersample)
    albedo = np.zeros(layers.shape[1:], np.float32)
    if with_albedo:
        albedo[_subpixels_of(rectangle, supersample)] = _albedo(model, lambda: render(rectangle))
    return BackgroundLight(np.ascontiguousarray(np.moveaxis(layers, 0, -1)), albedo)


def _render_layers(
    render: Callable[[Rectangle], F32],
    model: mujoco.MjModel,
    shadow_lights: Numbers,
    flickering: FlickeringLamps | None,
    rectangle: Rectangle,
    lens: Intrinsics,
    supersample: int,
) -> F32:
    """Return the layers of the background, (layers, rows, columns) sub-pixels [cd/m²].

    Args as those of `render_light`; `render` renders a rectangle with the lights of `model`.
    """
    image = (0, 0, lens.width, lens.height)
    whole = render(image)
    layers = np.zeros((1 + len(shadow_lights) + (flickering is not None), *whole.shape), np.float32)
    layers[0] = whole
    box = _subpixels_of(rectangle, supersample)
    if flickering is not None:
        with flickering.scaled(model, 0.0):
            layers[0] = np.minimum(render(image), whole)
        layers[-1] = whole - layers[0]
    off: dict[int, float] = dict.fromkeys((int(k) for k in shadow_lights), 0.0)
    if off:
        with changed_lights(model, off):
            layers[0][box] = rest = render(rectangle)
        for light, layer in zip(list(off)[1:], layers[2:], strict=False):
            others_off = {k: v for k, v in off.items() if k != light}
            with changed_lights(model, others_off):
                layer[box] = np.maximum(render(rectangle) - rest, 0.0)
        others = layers[2 : 1 + len(off)].sum(axis=0)[box]
        layers[1][box] = np.maximum(whole[box] - rest - others, 0.0)
        if flickering is not None:
            with changed_lights(model, off), flickering.scaled(model, 0.0):
                layers[0][box] = np.minimum(render(rectangle), rest)
            layers[-1][box] = rest - layers[0][box]
    return layers


def _subpixels_of(rectangle: Rectangle, supersample: int) -> tuple[slice, slice]:
    """Return the rows and columns of a rectangle's sub-pixels."""
    x0, y0, x1, y1 = (supersample * edge for edge in rectangle)
    return slice(y0, y1), slice(x0, x1)


def _averaged(image: F32, count: int) -> F32:
    """Return the means of squares of `count` × `count` samples."""
    if count == 1:
        return image
    size = image.shape[1] // count, image.shape[0] // count
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.float32)


def _albedo(model: mujoco.MjModel, render: Callable[[], F32]) -> F32:
    """Return the luminance per illuminance of each sub-pixel [cd/m² per lux].

    It is measured under the sky alone, which is equally bright in all directions, so that it does
    not depend on which way a surface faces.
    """
    sky = sky_lights(model)
    if not sky.size:
        return np.zeros_like(render())
    off: dict[int, float] = dict.fromkeys(range(model.nlight), 0.0)
    with changed_lights(model, off):
        emitted = render()
    with changed_lights(model, off | {int(sky[0]): 1.0}):
        return np.asarray(np.maximum(render() - emitted, 0.0) / np.float32(math.pi), np.float32)
