"""Lamps on the mains: turned down and up again, together."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.scene.lighting import OFF_EMISSION

Numbers = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class FlickeringLamps:
    """What hangs on the mains.

    Attributes:
        lights: (n,) numbers of lights.
        materials: (m,) numbers of materials that glow with them.
    """

    lights: Numbers
    materials: Numbers

    @contextmanager
    def scaled(self, model: mujoco.MjModel, factor: float) -> Iterator[None]:
        """Multiply their light for a while; a renderer learns of it at its next update."""
        emission = model.mat_emission.copy()
        model.mat_emission[self.materials] *= factor
        # Filament takes an emission of 0 as none given.
        model.mat_emission[self.materials] += OFF_EMISSION
        dimmed = {int(k): float(factor * model.light_intensity[k]) for k in self.lights}
        try:
            with changed_lights(model, dimmed):
                yield
        finally:
            model.mat_emission[:] = emission


@contextmanager
def changed_lights(model: mujoco.MjModel, intensities: dict[int, float]) -> Iterator[None]:
    """Give lights other intensities for a while; a renderer learns of it at its next update.

    Args:
        model: whose lights.
        intensities: by the light's number; [lux], [cd] or [cd/m²] as its type has it.
    """
    before = model.light_intensity.copy()
    for light, intensity in intensities.items():
        model.light_intensity[light] = intensity
    try:
        yield
    finally:
        model.light_intensity[:] = before


def sky_lights(model: mujoco.MjModel) -> Numbers:
    """(n,) numbers of the lights that come from all around."""
    return np.flatnonzero(model.light_type == mujoco.mjtLightType.mjLIGHT_IMAGE)
