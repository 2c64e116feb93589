"""Which stimuli make an envelope: speed by noise in full, every other factor against speed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from flybench.direction import CARDINAL
from scenarios.envelope.stimulus import Background, Stimulus, Surface
from scenarios.errors import ScenarioError

SPEED, NOISE = "speed_px_s", "noise_hz"
BASE = Stimulus()
SPEEDS_PX_S = (30.0, 60.0, 90.0, 120.0, 180.0, 240.0, 350.0, 500.0, 750.0, 1000.0, 1500.0, 2000.0)
NOISES_HZ = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0)
LEVELS: dict[str, tuple[Any, ...]] = {
    "contrast": (0.1, 0.2, 0.4, 0.8),
    "direction": CARDINAL,
    "length_px": (30, 60, 120, 240),
    "surface": tuple(Surface),
    "background": tuple(Background),
}
"""Levels of what is changed one factor at a time; each holds the base point's."""
MOST_POINTS = 1_000_000


@dataclass(frozen=True)
class Grid:
    """The points of an envelope.

    Attributes:
        speeds_px_s: image speeds [px/s].
        noises_hz: noise by pixel [Hz].
        levels: of the other factors, by name of the `Stimulus` field.
        crossed: factors of which every level is measured at every speed and noise; of the others
            every level is measured at every speed, at the base point's noise.
        seeds: how many drawings of each point, from seed 0 on.

    Raises:
        ScenarioError: an unknown factor, no level, a value that a stimulus cannot have, or more
            than a million points.
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
                    f"the factor to cross is {name!r}; allowed is {', '.join(self.levels)}; speed "
                    "and noise are always crossed"
                )
        for name, values in self._axes().items():
            if not values:
                raise ScenarioError(f"{name} has no level; give one or more, or leave it out")
        if self.seeds < 1:
            raise ScenarioError(f"seeds is {self.seeds}; allowed is 1 or more; 2 is quick")
        number = self.seeds * len(self.speeds_px_s) * len(self.noises_hz)
        number *= math.prod(len(self.levels[name]) for name in self.crossed)
        if number > MOST_POINTS:
            raise ScenarioError(
                f"the envelope has {number:,} points; allowed are {MOST_POINTS:,}; cross fewer "
                "factors, or give fewer levels"
            )
        self.points()

    def points(self) -> list[Stimulus]:
        """Every stimulus once, seed by seed."""
        blocks = [self._block(self.noises_hz, self.crossed)]
        blocks += [self._block((BASE.noise_hz,), (name,)) for name in self.levels]
        drawn = dict.fromkeys(itertools.chain.from_iterable(blocks))
        return [replace(point, seed=seed) for seed in range(self.seeds) for point in drawn]

    def _axes(self) -> dict[str, tuple[Any, ...]]:
        return {SPEED: self.speeds_px_s, NOISE: self.noises_hz} | self.levels

    def _block(self, noises_hz: Sequence[float], names: Sequence[str]) -> list[Stimulus]:
        axes = {SPEED: self.speeds_px_s, NOISE: noises_hz} | {n: self.levels[n] for n in names}
        values = itertools.product(*axes.values())
        return [replace(BASE, **dict(zip(axes, point, strict=True))) for point in values]
