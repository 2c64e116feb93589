"""Fixed order in which Filament draws, so that the same scene always gives the same image.

Where two surfaces have the same depth, Filament shows the one that it draws last. It draws opaque
surfaces in the order in which their materials were created. MuJoCo creates the materials of a frame
in the order of the addresses of its objects, which differs from process to process, and it deletes
every material that a frame does not use.

Here a second scene holds one object of each material, and is part of every frame, so that no
material is ever deleted. Its objects are added in the model's order, one a frame, so that each
material is created in a frame of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count as counting
from itertools import takewhile
from typing import Any

import mujoco
import numpy as np
from mujoco import mjrf

from sim.render.quiet_output import suppress_output

MAX_STATES = 8
"""States of the materials after which older ones are deleted (assumed: flickering lamps need two).
All materials are then created again, which costs a frame of one pixel for each."""
_WHOLE = -1
"""Number of a part that stands for an object without parts."""
_FAR_M = 1e6
"""Distance of the second scene's near plane: nothing is beyond it, so nothing is drawn [m]."""


class DrawOrder:
    """Creates the materials of a model in a fixed order and keeps them."""

    def __init__(self, context: Any, resources: Any, model: mujoco.MjModel) -> None:
        """Create the second scene, still empty.

        Args:
            context: Filament context.
            resources: meshes and textures of `model`.
            model: the model that is rendered.
        """
        self._context, self._resources, self._model = context, resources, model
        self._scene = context.create_scene(mjrf.SceneParams())
        self._states: dict[bytes, Any] = {}
        self._previous: dict[bytes, Any] = {}
        self._drawn = False
        self._known: set[tuple[float, ...]] = set()
        self._waiting: list[Any] = []
        red = mjrf.RenderTargetConfig(color_format=mjrf.PixelFormat.PIXEL_FORMAT_R32F)
        self._pixel = context.create_render_target(red)
        self._pixel.resize(1, 1)

    def update(self, data: mujoco.MjData) -> None:
        """Take note of new materials, after the model's colours may have changed.

        Args:
            data: poses of the model, whose kinematics must be up to date.
        """
        state = self._state()
        if state in self._states:
            return
        if len(self._states) >= MAX_STATES and self._drawn:
            # The frame that was drawn last still uses materials of these states.
            self._previous, self._states = self._states, {}
            self._known, self._drawn = set(), False
        renderables = mjrf.ModelRenderables(self._scene, self._resources)
        renderables.update(data)
        self._states[state] = renderables
        for renderable, shader in self._objects(renderables):
            self._scene.remove_renderable(renderable)
            key = (*shader, *_values(renderable.get_material()))
            if key not in self._known:
                self._known.add(key)
                self._waiting.append(renderable)

    def requests(self, request: Any) -> list[Any]:
        """Return what to render in one frame, so that every material is used.

        New materials are created first.

        Args:
            request: what the frame is to show.
        """
        self._drawn = True
        if self._waiting:
            with suppress_output():  # Filament complains that these frames are short
                self._create_waiting(request)
        return [self._blank(request, request.target), request]

    def _create_waiting(self, request: Any) -> None:
        """Create the materials of the objects that wait, one in each frame."""
        for renderable in self._waiting:
            self._scene.add_renderable(renderable)
            read = mjrf.ReadRequest(target=self._pixel)
            read.set_buffer(np.empty((1, 1), np.float32))
            blank = [self._blank(request, self._pixel)]
            self._context.wait_for_frame(self._context.render(blank, [read]))
        self._waiting.clear()

    def _blank(self, request: Any, target: Any) -> Any:
        """Return a request for the second scene that uses its materials and draws nothing."""
        blank = mjrf.RenderRequest()
        blank.scene, blank.target, blank.draw_mode = self._scene, target, request.draw_mode
        blank.camera = mjrf.Camera(
            pos=request.camera.pos,  # a plane that is seen from behind has another material
            forward=request.camera.forward,
            up=request.camera.up,
            frustum_bottom=-_FAR_M,
            frustum_top=_FAR_M,
            frustum_width=_FAR_M,
            frustum_near=_FAR_M,
            frustum_far=2 * _FAR_M,
        )
        blank.viewport.width = blank.viewport.height = 1
        blank.post_processing = blank.shadows = False
        blank.haze = blank.reflections = blank.headlight = False
        return blank

    def _state(self) -> bytes:
        """Return everything in the model that may change and that materials are made from."""
        m = self._model
        arrays = [
            m.geom_matid,
            m.geom_rgba,
            m.geom_size,
            m.site_matid,
            m.site_rgba,
            m.flex_rgba,
            m.skin_rgba,
            m.tendon_rgba,
            m.mat_rgba,
            m.mat_emission,
            m.mat_specular,
            m.mat_shininess,
            m.mat_reflectance,
            m.mat_metallic,
            m.mat_roughness,
            m.mat_texrepeat,
        ]
        return b"".join(array.tobytes() for array in arrays)

    def _objects(self, renderables: Any) -> Iterator[tuple[Any, tuple[int, ...]]]:
        """Yield everything that is drawn, in the model's order, and what determines its shader."""
        m, kind = self._model, mujoco.mjtObj
        for k in range(m.ngeom):
            shader = int(m.geom_type[k]), int(m.geom_dataid[k]), int(m.geom_matid[k])
            yield renderables.get_renderable(kind.mjOBJ_GEOM, k, _WHOLE), shader
        for k in range(m.nsite):
            shader = int(m.site_type[k]), _WHOLE, int(m.site_matid[k])
            yield renderables.get_renderable(kind.mjOBJ_SITE, k, _WHOLE), shader
        for k in range(m.nskin):
            yield renderables.get_renderable(kind.mjOBJ_SKIN, k, _WHOLE), (kind.mjOBJ_SKIN, k)
        for segmented, count in ((kind.mjOBJ_FLEX, m.nflex), (kind.mjOBJ_TENDON, m.ntendon)):
            for k in range(count):
                parts = (renderables.get_renderable(segmented, k, part) for part in counting())
                for renderable in takewhile(lambda found: found is not None, parts):
                    yield renderable, (segmented, k)


def _values(material: Any) -> tuple[float, ...]:
    """Return the numbers of a material."""
    values = [material.color, material.uv_scale, material.uv_offset]
    numbers = [getattr(material, name) for name in _NUMBERS]
    return (*np.concatenate(values).tolist(), *numbers)


_NUMBERS = ("emissive", "specular", "glossiness", "reflectance", "metallic", "roughness")
"""Names of a material's numbers."""
