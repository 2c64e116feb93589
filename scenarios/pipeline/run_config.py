"""Complete configuration of one run: scene, sensor, detector and seed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from detector.fly.config import FlyConfig
from emulator import SensorConfig
from scenarios.errors import ScenarioError
from scenarios.pipeline.registry import DETECTORS, FLY, is_fly
from sim import CrossingConfig


@dataclass(frozen=True)
class RunConfig:
    """Everything that determines the result of a run.

    Attributes:
        crossing: the scene and its motion.
        sensor: the event camera.
        method: name of the detector; see `scenarios.pipeline.user_detectors.find_method`.
        fly: parameters of the fly. None: the preset of the method. Other detectors have none.
        seed: seed of everything random, 0 to 2³² − 1.

    Raises:
        ScenarioError: the seed is out of range, or a method other than the fly has parameters of
            the fly.
    """

    crossing: CrossingConfig = field(default_factory=CrossingConfig)
    sensor: SensorConfig = field(default_factory=SensorConfig)
    method: str = FLY
    fly: FlyConfig | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        if is_fly(self.method):
            object.__setattr__(self, "fly", self.fly or DETECTORS[self.method].config)
        elif self.fly is not None:
            raise ScenarioError(
                f"The method is {self.method}, but parameters of the fly are given. Allowed are "
                f"these parameters for {' and '.join(filter(is_fly, DETECTORS))} only. Leave them "
                "out."
            )
        if not 0 <= self.seed < 2**32:
            raise ScenarioError(
                f"seed is {self.seed}. Allowed is a whole number from 0 to {2**32 - 1}. The "
                "default is 0."
            )

    @property
    def name(self) -> str:
        """Descriptive folder name; a digest stands for all other parameters that are changed."""
        c = self.crossing
        method = "" if self.method == FLY else f"_{self.method.replace(':', '.')}"
        named = CrossingConfig(c.lighting, c.omega_rad_s, c.direction)
        default = replace(self, crossing=named, sensor=SensorConfig(), fly=None)
        suffix = ""
        if default.parameters() != self.parameters():
            digest = hashlib.sha256(repr(sorted(self.parameters().items())).encode()).hexdigest()
            suffix = f"_{digest[:8]}"
        name = f"{c.lighting}_{c.direction}_{c.omega_rad_s:g}rad_s_seed{self.seed}"
        return name + method + suffix

    @property
    def title(self) -> str:
        """Name of the run for people, such as "night, 1.42 rad/s, moving left"."""
        c = self.crossing
        method = "" if self.method == FLY else f", {self.method}"
        return f"{c.lighting}, {c.omega_rad_s:.3g} rad/s, moving {c.direction}{method}"

    def parameters(self) -> dict[str, object]:
        """Return every parameter by its dotted name, such as "crossing.omega_rad_s"."""
        return dict(flatten(asdict(self) | {"crossing": self.crossing.resolved()}))


def flatten(values: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Yield the values of nested dictionaries with their dotted names."""
    for name, value in values.items():
        if isinstance(value, dict):
            yield from flatten(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value
