"""All experiments on one sensor: its data sheet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from emulator.characterisation import (
    arbiter,
    background,
    bandwidth,
    dynamic_range,
    intervals,
    latency,
    leak,
    photon_transfer,
    refractory,
    s_curve,
)
from emulator.characterisation.section import Section
from emulator.config import SensorConfig

EXPERIMENTS: Mapping[str, Callable[..., Section]] = {
    "s_curve": s_curve.measure,
    "bandwidth": bandwidth.measure,
    "latency": latency.measure,
    "dynamic_range": dynamic_range.measure,
    "refractory": refractory.measure,
    "background": background.measure,
    "intervals": intervals.measure,
    "leak": leak.measure,
    "arbiter": arbiter.measure,
    "photon_transfer": photon_transfer.measure,
}
"""Every experiment by name, in the order of the data sheet; each takes a sensor and a seed."""


@dataclass(frozen=True, eq=False)
class Datasheet:
    """What the experiments found out about one sensor.

    Attributes:
        config: the sensor.
        seed: of everything random.
        sections: what each experiment found, by its name in `EXPERIMENTS`.
    """

    config: SensorConfig
    seed: int
    sections: Mapping[str, Section]


def characterise(
    config: SensorConfig,
    *,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> Datasheet:
    """Run every experiment on a sensor.

    Args:
        config: the sensor, whichever; experiments replace its size.
        seed: of everything random; the same gives the same figures.
        progress: is told how many experiments are done, and how many there are.

    Returns:
        The data sheet; `sheet.sections["leak"].figures["leak without light"].measured` is a
        figure, in the unit that stands beside it.

    Raises:
        SensorConfigError: the seed is negative or no integer.
    """
    sections = {}
    for done, (name, measure) in enumerate(EXPERIMENTS.items(), start=1):
        sections[name] = measure(config, seed=seed)
        if progress is not None:
            progress(done, len(EXPERIMENTS))
    return Datasheet(config, seed, sections)
