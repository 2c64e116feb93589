"""The data sheet of a sensor: the results of all experiments."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import wraps

from emulator.arguments import check_config, check_seed
from emulator.characterisation.comparison import DVS128, chip_of, mark_other_sensors
from emulator.characterisation.experiments import (
    arbiter,
    background,
    bandwidth,
    dynamic_range,
    intervals,
    lamp,
    latency,
    leak,
    line_order,
    noise_spread,
    photon_transfer,
    refractory,
    s_curve,
)
from emulator.characterisation.section import Section
from emulator.config import SensorConfig

FRAME_EXPERIMENT = "photon_transfer"
"""The experiment that needs APS frames."""


def _checked(measure: Callable[..., Section]) -> Callable[..., Section]:
    """Add checks of sensor and seed to an experiment, and mark figures of other sensors."""

    @wraps(measure)
    def run(config: SensorConfig, *, seed: int) -> Section:
        check_config(config)
        return mark_other_sensors(measure(config, seed=check_seed(seed)), config)

    return run


_MEASURES: Mapping[str, Callable[..., Section]] = {
    "s_curve": s_curve.measure,
    "bandwidth": bandwidth.measure,
    "latency": latency.measure,
    "dynamic_range": dynamic_range.measure,
    "refractory": refractory.measure,
    "background": background.measure,
    "noise_spread": noise_spread.measure,
    "intervals": intervals.measure,
    "leak": leak.measure,
    "lamp": lamp.measure,
    "arbiter": arbiter.measure,
    "line_order": line_order.measure,
    "photon_transfer": photon_transfer.measure,
}

EXPERIMENTS = {name: _checked(measure) for name, measure in _MEASURES.items()}
"""All experiments by name, in the order of the data sheet. Call each with a sensor and a seed."""


@dataclass(frozen=True, eq=False)
class Datasheet:
    """Results of the experiments on one sensor.

    Attributes:
        config: configuration of the sensor.
        seed: random seed.
        sections: result of each experiment, by its name in `EXPERIMENTS`.
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
        config: configuration of any sensor; experiments replace its size.
        seed: random seed; the same seed gives the same figures.
        frames: whether the chip has APS frames. If not, their experiment is left out. None: it has
            them unless it is the DVS128, as `preset` returns it.
        progress: called with the number of experiments done and the number of all.

    Returns:
        The data sheet. For example, `sheet.sections["leak"].figures["leak without light"].measured`
        is one measured figure; its unit is `.unit`.

    Raises:
        SensorConfigError: `config` is not a sensor configuration, or the seed is not a whole number
            from 0.
    """
    if frames is None:
        frames = chip_of(check_config(config)) != DVS128
    chosen = {name: run for name, run in EXPERIMENTS.items() if frames or name != FRAME_EXPERIMENT}
    sections = {}
    for done, (name, measure) in enumerate(chosen.items(), start=1):
        sections[name] = measure(config, seed=seed)
        if progress is not None:
            progress(done, len(chosen))
    return Datasheet(config, seed, sections)
