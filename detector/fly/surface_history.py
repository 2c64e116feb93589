"""The surfaces of past hops, from which the delayed signal comes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from detector.fly.config import FlyConfig

F32 = npt.NDArray[np.float32]


class SurfaceHistory:
    """Keeps the surfaces of the last hops for the longest delay.

    Attributes:
        activity: mean of both surfaces of the last hop before inhibition, added; 0 without any.
    """

    def __init__(self, config: FlyConfig, *, grid: tuple[int, int]) -> None:
        """Start with empty surfaces.

        Args:
            config: hops and delays.
            grid: rows and columns of cells.
        """
        self.activity = 0.0
        self._delays_hops = config.delays_hops
        hops = max(config.delays_hops) + 1
        self._surfaces = np.zeros((hops, 2, *grid), np.float32)
        self._has_surface = np.zeros(hops, np.bool_)

    @property
    def is_quiet(self) -> bool:
        """True if every surface that is kept is empty."""
        return not self._has_surface.any()

    def averaged(self, *, hop: int) -> F32:
        """Return a copy of the surfaces of a hop, at most the longest delay ago.

        Returns:
            (2, rows, columns) float32, dimensionless: OFF surface, ON surface.
        """
        surface: F32 = self._surfaces[hop % len(self._surfaces)].copy()
        return surface

    def delayed(self, *, hop: int) -> F32:
        """Return the delayed signal Ĥ of equation 9: the mean surface over the delays before a hop.

        Correlation is linear in it, so that several delays cost no more than one.
        """
        first, *further = self._delays_hops
        surface = self.averaged(hop=hop - first)
        for lag in further:
            surface += self._surfaces[(hop - lag) % len(self._surfaces)]
        surface /= len(self._delays_hops)
        return surface

    def _keep(self, hop: int, surface: F32 | None) -> F32:
        """Keep the surfaces of a hop, None if they are empty, and return a copy."""
        slot = hop % len(self._surfaces)
        self._has_surface[slot] = surface is not None
        self._surfaces[slot] = 0.0 if surface is None else surface
        return self.averaged(hop=hop)
