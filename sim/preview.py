"""A colour picture of a crossing for the eye, drawn beside the photometric samples."""

from __future__ import annotations

from types import TracebackType

import mujoco
import numpy as np
import numpy.typing as npt

from sim.crossing import Crossing
from sim.renderer import FilamentRenderer
from sim.scene import preview_model


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
        scene = self._crossing.scene
        scene.place(self._data, self._crossing.position_m(t_us))
        self._renderer.update(self._data)
        return self._renderer.preview(scene.pose, scale=scale)
