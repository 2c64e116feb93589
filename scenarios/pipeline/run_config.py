"""One run, fully specified: scene, sensor, detector, seed."""

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
    """Everything that determines a run's result.

    Attributes:
        crossing: the scene and its motion.
        sensor: the camera.
        method: name of the detector; see `scenarios.pipeline.registry.find_method`.
        fly: the fly's parameters; None: those of the method's name, and of a method that is no fly
            there are none.
        seed: of everything random, 0 to 2³² − 1.

    Raises:
        ScenarioError: the seed is out of range, or a method that is no fly has a fly's parameters.
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
                f"The method is {self.method}, which takes no parameters of the fly. Allowed are "
                f"they for {' and '.join(filter(is_fly, DETECTORS))}. Leave them out."
            )
        if not 0 <= self.seed < 2**32:
            raise ScenarioError(
                f"seed is {self.seed}; allowed is 0 to {2**32 - 1}; choose one, such as 0"
            )

    @property
    def name(self) -> str:
        """A folder name that tells what is in it; a digest stands for whatever else is special."""
        c = self.crossing
        method = "" if self.method == FLY else f"_{self.method.replace(':', '.')}"
        plain = CrossingConfig(c.lighting, c.omega_rad_s, c.direction)
        usual = replace(self, crossing=plain, sensor=SensorConfig(), fly=None)
        special = ""
        if usual.parameters() != self.parameters():
            digest = hashlib.sha256(repr(sorted(self.parameters().items())).encode()).hexdigest()
            special = f"_{digest[:8]}"
        name = f"{c.lighting}_{c.direction}_{c.omega_rad_s:g}rad_s_seed{self.seed}"
        return name + method + special

    def parameters(self) -> dict[str, object]:
        """Every parameter by its dotted name, such as "crossing.omega_rad_s"."""
        return dict(flat(asdict(self) | {"crossing": self.crossing.resolved()}))


def flat(values: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Values of nested dictionaries by their dotted names."""
    for name, value in values.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value
