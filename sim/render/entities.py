"""Count Filament's entities, of which a process has 131 071.

Every part of a geom or site is an entity. Filament reuses those of a closed renderer only after
every open renderer has drawn again, so that a renderer that stays open and idle keeps all of them.
MuJoCo ends the process, without a word, when none is left.
"""

from __future__ import annotations

import itertools
import threading
from dataclasses import dataclass

import mujoco
import numpy as np

from sim.errors import RendererError

MAX_ENTITIES = 100_000
"""Maximum number of entities that are counted. The other 31 071 are for what is not: lights,
cameras, skins, flexes, tendons, and materials that change."""

_PARTS = {
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): 3,
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): 3,
    int(mujoco.mjtGeom.mjGEOM_PLANE): 2,
}
"""Entities of a geom by its type; 1 of all others (measured: 1000 geoms until MuJoCo gives up)."""
_SCENES = 2
"""Scenes of a renderer that show the model: its own, and that of `sim.render.draw_order`."""

_clock = itertools.count()
_lock = threading.Lock()


@dataclass(eq=False)
class Entities:
    """The entities of one renderer. All methods may be called in any thread.

    Attributes:
        count: number of entities.
        drawn: moment of the last image; −1 if there is none yet.
        closed: moment when the renderer was closed; None while it is open.
    """

    count: int
    drawn: int = -1
    closed: int | None = None

    def note_image(self) -> None:
        """Take note that the renderer has drawn an image."""
        self.drawn = next(_clock)

    def release(self) -> None:
        """Take note that the renderer is closed, or no longer exists."""
        if self.closed is None:
            self.closed = next(_clock)


_used: list[Entities] = []


def reserve_entities(model: mujoco.MjModel) -> Entities:
    """Count the entities of a new renderer.

    Args:
        model: the model that is rendered.

    Raises:
        RendererError: the process has too few left.
    """
    types = np.concatenate([model.geom_type, model.site_type])
    count = _SCENES * sum(_PARTS.get(int(kind), 1) for kind in types)
    with _lock:
        still_open = [used.drawn for used in _used if used.closed is None]
        seen = min(still_open) if still_open else max((used.drawn for used in _used), default=-1)
        _used[:] = [used for used in _used if used.closed is None or used.closed > seen]
        total = sum(used.count for used in _used)
        if total + count > MAX_ENTITIES:
            raise RendererError(
                f"a renderer of this model needs {count} entities of Filament, and {total} are in "
                f"use (open renderers: {len(still_open)}). Those of closed renderers are free once "
                f"every open one has drawn again. Allowed are {MAX_ENTITIES} in a process. Close "
                "renderers that no longer draw: photometric cameras, and samples of a crossing "
                "that were not read to their end."
            )
        entities = Entities(count)
        _used.append(entities)
    return entities
