"""A colour picture of a crossing for the eye, drawn beside the photometric samples."""

from __future__ import annotations

import copy
from types import TracebackType

import mujoco
import numpy as np
import numpy.typing as npt

from sim.crossing import Crossing
from sim.facade_style import LIT_WINDOW
from sim.light import SKY_TEXTURE
from sim.renderer import FilamentRenderer
from sim.scene import Scene

PREVIEW_LUX = 60_000.0
"""What the preview's eye is adapted to (by eye)."""
PREVIEW_SKY_RGB = (170, 205, 255)


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

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._renderer.close()

    def draw(self, t_us: int, *, scale: int = 2) -> npt.NDArray[np.uint8]:
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
    model.mat_emission[:] *= gain**0.25  # lamps in full would lose their hue
    windows = [k for k in range(model.nmat) if model.mat(k).name.startswith(LIT_WINDOW)]
    model.mat_emission[windows] *= gain**0.6
    sky = int(model.tex_adr[model.texture(SKY_TEXTURE).id])
    model.tex_data[sky:].reshape(-1, 3)[:] = PREVIEW_SKY_RGB
    return model
