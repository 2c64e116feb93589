"""The emulator on the test bench: the experiments with which real event cameras are characterised.

Each experiment is a file; each uses nothing of the emulator but what any user can, and looks at
causes only where it says so. `characterise` runs them all; `fit_static` and `fit_ramps` go the
other way, from a recording to the sensor's parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

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
from emulator.characterisation.ramp_fit import Thresholds, fit_ramps
from emulator.characterisation.section import (
    Plot,
    Published,
    Quantity,
    Section,
    Series,
    Style,
)
from emulator.characterisation.static_fit import StaticFit, fit_static
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


def characterise(
    config: SensorConfig,
    *,
    seed: int,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Section]:
    """Run every experiment.

    Args:
        config: the sensor; experiments replace its size.
        seed: of everything random.
        progress: is told how many experiments are done, and how many there are.

    Returns:
        What each experiment found, by its name in `EXPERIMENTS`.
    """
    sections = {}
    for done, (name, measure) in enumerate(EXPERIMENTS.items(), start=1):
        sections[name] = measure(config, seed=seed)
        if progress is not None:
            progress(done, len(EXPERIMENTS))
    return sections


__all__ = [
    "EXPERIMENTS",
    "Plot",
    "Published",
    "Quantity",
    "Section",
    "Series",
    "StaticFit",
    "Style",
    "Thresholds",
    "characterise",
    "fit_ramps",
    "fit_static",
]
