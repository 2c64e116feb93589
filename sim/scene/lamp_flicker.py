"""Flickering lamps: all lamps on the mains, whose output changes together."""

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
    """Lamps on the mains.

    Attributes:
        lights: (n,) numbers of the lights.
        materials: (m,) numbers of the materials that glow with them.
    """

    lights: Numbers
    materials: Numbers

    @contextmanager
    def scaled(self, model: mujoco.MjModel, factor: float) -> Iterator[None]:
        """Multiply the output of the lamps inside the with block, from a renderer's next update."""
        emission = model.mat_emission.copy()
        model.mat_emission[self.materials] *= factor
        # Filament reads an emission of 0 as "no emission given".
        model.mat_emission[self.materials] += OFF_EMISSION
        dimmed = {int(k): float(factor * model.light_intensity[k]) for k in self.lights}
        try:
            with changed_lights(model, dimmed):
                yield
        finally:
            model.mat_emission[:] = emission


@contextmanager
def changed_lights(model: mujoco.MjModel, intensities: dict[int, float]) -> Iterator[None]:
    """Change intensities of lights while the block runs; a renderer sees it after its next update.

    Args:
        model: the model, which is restored afterwards.
        intensities: intensity by number of the light; [lux], [cd] or [cd/m²], depending on the type
            of the light.
    """
    before = model.light_intensity.copy()
    for light, intensity in intensities.items():
        model.light_intensity[light] = intensity
    try:
        yield
    finally:
        model.light_intensity[:] = before


def sky_lights(model: mujoco.MjModel) -> Numbers:
    """Return the (n,) numbers of the image lights, which light from all directions."""
    return np.flatnonzero(model.light_type == mujoco.mjtLightType.mjLIGHT_IMAGE)
