"""The stimuli of an envelope: speed × noise in full, and every other factor against speed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from flybench.direction import CARDINAL
from scenarios.envelope.stimulus import Background, Stimulus, Surface
from scenarios.errors import ScenarioError

SPEED, NOISE, TILT, SURFACE = "speed_px_s", "noise_hz", "tilt_deg", "surface"
BASE = Stimulus()
SPEEDS_PX_S = (30.0, 60.0, 90.0, 120.0, 180.0, 240.0, 350.0, 500.0, 750.0, 1000.0, 1500.0, 2000.0)
NOISES_HZ = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0)
LEVELS: dict[str, tuple[Any, ...]] = {
    "contrast": (0.1, 0.2, 0.4, 0.8),
    "direction": CARDINAL,
    "length_px": (30, 60, 120, 240),
    SURFACE: tuple(Surface),
    "background": tuple(Background),
    TILT: (0.0, 5.0, 15.0, 25.0, 35.0),
    "events_per_edge": (1, 2, 3, 4, 5),
}
"""Levels of the other factors; each list contains the level of the base point."""
TILTED_SURFACES = (Surface.BAR, Surface.BAND)
"""Surfaces for which tilt is measured too, besides that of the base point: the long edges of a bar
are along its path, and the edges of a band are all that is seen of it."""
MAX_POINTS = 1_000_000


@dataclass(frozen=True)
class Grid:
    """The points of an envelope.

    Attributes:
        speeds_px_s: image speeds [px/s].
        noises_hz: noise rates per pixel [Hz].
        levels: levels of the other factors, by name of the `Stimulus` field.
        crossed: factors whose levels are measured at every speed and noise. The levels of the
            other factors are measured at every speed, with the noise of the base point.
        seeds: number of repetitions of each point, with the seeds 0, 1, 2 and so on.

    Raises:
        ScenarioError: a factor is unknown, a factor has no level, a value is invalid for a
            stimulus, or there are more than a million points.
    """

    speeds_px_s: tuple[float, ...] = SPEEDS_PX_S
    noises_hz: tuple[float, ...] = NOISES_HZ
    levels: dict[str, tuple[Any, ...]] = field(default_factory=lambda: dict(LEVELS))
    crossed: tuple[str, ...] = ("direction",)
    seeds: int = 2

    def __post_init__(self) -> None:
        for name in self.crossed:
            if name not in self.levels:
                raise ScenarioError(
                    f"The factor to cross is {name!r}. Allowed is {', '.join(self.levels)}. Speed "
                    "and noise are always crossed."
                )
        for name, values in self._axes().items():
            if not values:
                raise ScenarioError(
                    f"{name} has no level. Allowed is one level or more. Add one, or leave the "
                    "factor out."
                )
        if self.seeds < 1:
            raise ScenarioError(f"seeds is {self.seeds}. Allowed is 1 or more. The default is 2.")
        number = self.seeds * len(self.speeds_px_s) * len(self.noises_hz)
        number *= math.prod(len(self.levels[name]) for name in self.crossed)
        if number > MAX_POINTS:
            raise ScenarioError(
                f"The envelope has {number:,} points. Allowed are {MAX_POINTS:,}. Cross fewer "
                "factors, or choose fewer levels."
            )
        self.points()

    def points(self) -> list[Stimulus]:
        """Return every stimulus once, seed by seed."""
        blocks = [self._block(self.noises_hz, self.crossed)]
        blocks += [self._block((BASE.noise_hz,), (name,)) for name in self.levels]
        if TILT in self.levels:
            blocks += [self._block((BASE.noise_hz,), (TILT,), s) for s in TILTED_SURFACES]
        unique = dict.fromkeys(itertools.chain.from_iterable(blocks))
        return [replace(point, seed=seed) for seed in range(self.seeds) for point in unique]

    def _axes(self) -> dict[str, tuple[Any, ...]]:
        return {SPEED: self.speeds_px_s, NOISE: self.noises_hz} | self.levels

    def _block(
        self, noises_hz: Sequence[float], names: Sequence[str], surface: Surface = BASE.surface
    ) -> list[Stimulus]:
        axes: dict[str, Sequence[Any]] = {SURFACE: (surface,), SPEED: self.speeds_px_s}
        axes |= {NOISE: noises_hz} | {name: self.levels[name] for name in names}
        values = itertools.product(*axes.values())
        return [replace(BASE, **dict(zip(axes, point, strict=True))) for point in values]
