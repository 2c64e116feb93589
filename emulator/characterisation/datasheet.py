"""All experiments on one sensor: its data sheet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import wraps

from emulator.arguments import check_config, check_seed
from emulator.characterisation.comparison import DVS128, chip_of, compared
from emulator.characterisation.experiments import (
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

FRAMES = "photon_transfer"
"""The experiment that looks at frames."""


def _of_any_sensor(measure: Callable[..., Section]) -> Callable[..., Section]:
    """An experiment that refuses what is no sensor or seed, and says whose figures it compares."""

    @wraps(measure)
    def run(config: SensorConfig, *, seed: int) -> Section:
        check_config(config)
        return compared(measure(config, seed=check_seed(seed)), config)

    return run


_MEASURES: Mapping[str, Callable[..., Section]] = {
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

EXPERIMENTS = {name: _of_any_sensor(measure) for name, measure in _MEASURES.items()}
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
    frames: bool | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Datasheet:
    """Run every experiment on a sensor.

    Args:
        config: the sensor, whichever; experiments replace its size.
        seed: of everything random; the same gives the same figures.
        frames: whether the chip has frames; where not, their experiment is left out. None: yes,
            unless it is the DVS128, as `preset` gives it.
        progress: is told how many experiments are done, and how many there are.

    Returns:
        The data sheet; `sheet.sections["leak"].figures["leak without light"].measured` is a
        figure, in the unit that stands beside it.

    Raises:
        SensorConfigError: the configuration is none, or the seed is negative or no integer.
    """
    if frames is None:
        frames = chip_of(check_config(config)) != DVS128
    chosen = {name: run for name, run in EXPERIMENTS.items() if frames or name != FRAMES}
    sections = {}
    for done, (name, measure) in enumerate(chosen.items(), start=1):
        sections[name] = measure(config, seed=seed)
        if progress is not None:
            progress(done, len(chosen))
    return Datasheet(config, seed, sections)
